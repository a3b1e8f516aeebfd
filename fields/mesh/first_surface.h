#pragma once
/// The first surface that a ray hits. Implemented with Embree.

#include "fields/base/embree_device.h"
#include "fields/mesh/mesh.h"

#include <memory>
#include <optional>

struct RTCSceneTy;

namespace haarfield {

/// A BVH of triangles. Safe to share between threads.
class FirstSurface {
public:
    /// The first intersection of a ray with a triangle.
    struct Hit {
        std::uint32_t triangle;
        bool is_front;  ///< True if the ray hits the front.
        float u, v;     ///< Barycentric: the triangle's corners have weights 1 - u - v, u and v.
    };

    /// Copies the required data.
    explicit FirstSurface(const Mesh& mesh);

    /// Returns the first triangle in a direction, at any distance.
    std::optional<Hit> operator()(const Vec3f& from, const Vec3f& direction) const;

    /// Tests whether a triangle intersects the segment from `from` to `from + way`.
    bool is_met(const Vec3f& from, const Vec3f& way) const;

private:
    EmbreeDevice device_;
    std::unique_ptr<RTCSceneTy, void (*)(RTCSceneTy*)> scene_;
};

}  // namespace haarfield
