#pragma once
/// Shadow rays from points towards light, against the original meshes (Embree).

#include <array>
#include <cstdint>
#include <span>

#include "shading/visibility/instanced_triangles.h"
#include "shading/visibility/light_filters.h"

namespace haarfield {

/// The triangles of a scene's instances, for shadow rays. Threads may share it while nothing is placed.
///
/// Triangles block light from both sides. The result for a ray does not depend on the other rays of its
/// packet.
class ShadowRays {
public:
    /// Largest number of points per call.
    static constexpr std::size_t packet = 16;
    static constexpr std::size_t no_instance = ~std::size_t(0);  ///< The index of no instance.
    /// Final fraction of a ray to a nearby light in which occluders are ignored, such as the light's surface.
    static constexpr float last_part = 1e-4f;

    /// Builds the triangles of all entities, and the scene of the instances.
    ///
    /// cost  that of InstancedTriangles.
    void build(const ShadedScene& scene);

    /// Updates the placements of the instances.
    ///
    /// cost  2 us per instance.
    void place(const ShadedScene& scene) { triangles_.place(scene); }

    /// Tests which of at most 16 points are occluded from a distant light: bit i of the result for point i.
    ///
    /// points     in the world, off their surfaces; points of a call should be neighbours in space.
    /// wanted     bit i: test point i; other bits of the result are 0.
    /// direction  towards the light.
    /// without    an instance that blocks nothing; one of the first 65,536.
    /// cost       40 to 80 ns per tested point, with 20,000 triangles.
    std::uint16_t blocked(std::span<const Vec3f> points, std::uint16_t wanted, const Vec3f& direction,
                          std::size_t without = no_instance) const;
    /// Tests one point against a distant light.
    bool is_blocked(const Vec3f& point, const Vec3f& direction) const;

    /// Tests which of at most 16 points are occluded from places in the scene. Occluders in the last_part of
    /// a ray are ignored.
    ///
    /// ends  ends of the rays, by point. Occluders behind them are ignored.
    /// cost  as for distant light.
    std::uint16_t blocked_from(std::span<const Vec3f> points, std::uint16_t wanted,
                               std::span<const Vec3f> ends, std::size_t without = no_instance) const;

    /// Tests one point against a place in the scene.
    bool is_blocked_from(const Vec3f& point, const Vec3f& end, std::size_t without = no_instance) const;

    /// Returns the fraction of a lamp's light that passes the scene's filters; see LightFilters.
    Rgb transmitted(const Vec3f& point, const Vec3f& end) const {
        return filters_ ? filters_->transmitted(point, end) : Rgb(1.0f);
    }

private:
    InstancedTriangles triangles_;
    std::shared_ptr<const LightFilters> filters_;
};

}  // namespace haarfield
