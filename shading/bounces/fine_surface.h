#pragma once
/// Nearest hits of rays with the fine meshes of a scene.

#include <array>
#include <optional>
#include <span>

#include "shading/visibility/instanced_triangles.h"

namespace haarfield {

/// The intersection of a ray with a fine mesh.
struct SurfaceHit {
    std::uint32_t instance = 0, triangle = 0;
    float u = 0, v = 0;    ///< Barycentric coordinates of the second and third corners.
    float distance = 0;    ///< From the origin of the ray. [m]
    bool is_back = false;  ///< True if the ray hits the back of the triangle.

    std::array<float, 3> weights() const { return {1 - u - v, u, v}; }  ///< Returns those of all corners.
};

/// The fine meshes of all instances of a scene, for ray queries. Threads may share it while none calls place.
class FineSurface {
public:
    /// cost  about 0.3 us per triangle of the fine meshes.
    explicit FineSurface(const ShadedScene& scene);

    /// Updates the placements of the instances.
    void place(const ShadedScene& scene) { triangles_.place(scene); }

    /// Returns the nearest hit of a ray in the world.
    ///
    /// from       offset from the surface that the ray leaves.
    /// direction  unit length.
    /// cost       about 0.2 us.
    std::optional<SurfaceHit> first_hit(const ShadedScene& scene, const Vec3f& from,
                                        const Vec3f& direction) const;

    static constexpr std::size_t packet = 16;  ///< Rays of one packet.
    /// The hits of a packet, by ray.
    using Hits = std::array<std::optional<SurfaceHit>, packet>;

    /// Returns the nearest hits of rays from one point: those of first_hit, up to rounding.
    ///
    /// directions  at most `packet`, of unit length. Similar directions are faster.
    /// cost        about 1 us.
    Hits first_hits(const ShadedScene& scene, const Vec3f& from, std::span<const Vec3f> directions) const;

    /// Tests which points of surfaces are hidden from a point: bit i of the result for end i. Surfaces in the
    /// ShadowRays::last_part of each ray are ignored.
    ///
    /// ends  at most `packet`, in the world.
    /// cost  about 0.7 us.
    std::uint16_t hidden(const Vec3f& from, std::span<const Vec3f> ends) const;

private:
    InstancedTriangles triangles_;
};

}  // namespace haarfield
