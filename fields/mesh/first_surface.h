#pragma once
/// The first surface that a ray meets. Embree's work.

#include "fields/base/embree_device.h"
#include "fields/mesh/mesh.h"

#include <memory>
#include <optional>

struct RTCSceneTy;

namespace haarfield {

/// Triangles for rays. Safe to share between threads.
class FirstSurface {
public:
    struct Hit {
        std::uint32_t triangle;
        bool is_front;  ///< The ray arrives at the front.
        float u, v;     ///< The triangle's corners weigh 1 - u - v, u and v.
    };

    /// Copies what it needs.
    explicit FirstSurface(const Mesh& mesh);

    /// The first triangle in a direction, however far.
    std::optional<Hit> operator()(const Vec3f& from, const Vec3f& direction) const;

    /// True if a triangle lies between two points: `from` and `from + way`.
    bool is_met(const Vec3f& from, const Vec3f& way) const;

private:
    EmbreeDevice device_;
    std::unique_ptr<RTCSceneTy, void (*)(RTCSceneTy*)> scene_;
};

}  // namespace haarfield
