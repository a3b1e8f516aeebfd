#pragma once
/// Rays from points towards light, past the meshes as they were read: Embree's work.

#include <array>
#include <cstdint>
#include <span>

#include "shading/visibility/instanced_triangles.h"

namespace haarfield {

/// The instances of a scene as triangles. Safe to share between threads while nothing is placed.
///
/// Every triangle blocks from both sides. Hits are the same whichever rays are asked for together.
class ShadowRays {
public:
    /// So many points are asked for at a time.
    static constexpr std::size_t packet = 16;
    static constexpr std::size_t no_instance = ~std::size_t(0);  ///< The number of none.
    /// What lies in the last part of the way to a near light does not block it: the surface that it lies on.
    static constexpr float last_part = 1e-4f;

    /// Builds what rays need: by entity, then of all instances.
    ///
    /// cost  that of InstancedTriangles.
    void build(const ShadedScene& scene);

    /// The instances as they stand now.
    ///
    /// cost  2 us each.
    void place(const ShadedScene& scene) { triangles_.place(scene); }

    /// Which of at most 16 points are blocked towards a light, however far: bit i of the result for point i.
    ///
    /// points     in the world, off the surfaces that they belong to; neighbours in space should be together.
    /// wanted     bit i: point i matters; of others the bit is 0.
    /// direction  towards the light.
    /// without    an instance that blocks nothing; one of the first 65,536.
    /// cost       40 to 80 ns a wanted point, with 20,000 triangles.
    std::uint16_t blocked(std::span<const Vec3f> points, std::uint16_t wanted, const Vec3f& direction,
                          std::size_t without = no_instance) const;
    /// The same of one point.
    bool is_blocked(const Vec3f& point, const Vec3f& direction) const;

    /// Which of at most 16 points are blocked from places in the scene, but for last_part of the way.
    ///
    /// ends  where the rays end, by point; what lies behind them does not matter.
    /// cost  as that of distant light.
    std::uint16_t blocked_from(std::span<const Vec3f> points, std::uint16_t wanted,
                               std::span<const Vec3f> ends, std::size_t without = no_instance) const;

    /// The same of one point.
    bool is_blocked_from(const Vec3f& point, const Vec3f& end, std::size_t without = no_instance) const;

private:
    InstancedTriangles triangles_;
};

}  // namespace haarfield
