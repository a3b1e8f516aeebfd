#pragma once
/// The fine meshes of a scene, for rays that ask what they meet.

#include <optional>

#include "shading/visibility/instanced_triangles.h"

namespace haarfield {

/// Where a ray meets a fine mesh: the corners of the triangle weigh 1 - u - v, u and v.
struct SurfaceHit {
    std::uint32_t instance = 0, triangle = 0;
    float u = 0, v = 0;
    float distance = 0;    ///< From the ray's origin. [m]
    bool is_back = false;  ///< It is met from behind.

    std::array<float, 3> weights() const { return {1 - u - v, u, v}; }  ///< Of the triangle's corners.
};

/// The instances of a scene, as finely as they are baked. Safe to share between threads while nothing is
/// placed.
class FineSurface {
public:
    /// cost  some 0.3 us a triangle of the fine meshes.
    explicit FineSurface(const ShadedScene& scene);

    /// The instances as they stand now.
    void place(const ShadedScene& scene) { triangles_.place(scene); }

    /// The first thing that a ray in the world meets.
    ///
    /// from       off the surface that it belongs to.
    /// direction  unit length.
    /// cost       some 0.2 us.
    std::optional<SurfaceHit> first_hit(const ShadedScene& scene, const Vec3f& from,
                                        const Vec3f& direction) const;

    /// The point of the entity's own surface right below one beside it, in the entity's frame; of the hit the
    /// instance is left 0.
    std::optional<SurfaceHit> below(std::size_t entity, const Vec3f& from, const Vec3f& normal) const;

private:
    InstancedTriangles triangles_;
};

}  // namespace haarfield
