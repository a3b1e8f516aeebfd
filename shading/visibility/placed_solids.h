#pragma once
/// The closed pieces of a scene's instances: points inside of them are visible from nowhere.

#include "shading/scene/shaded_scene.h"
#include "shading/visibility/instance_grid.h"

namespace haarfield {

/// The instances that have closed pieces, as they are placed.
///
/// The entities' occlusion must outlive it. Safe to share between threads.
class PlacedSolids {
public:
    PlacedSolids() : PlacedSolids(ShadedScene()) {}  ///< None.
    /// cost  that of an InstanceGrid.
    explicit PlacedSolids(const ShadedScene& scene);

    /// Tests whether a point lies inside another instance than its own: inside the closed pieces of its
    /// original mesh, or of its coarse mesh, in which a vertex would see nothing.
    ///
    /// point  in the world. [m]
    /// cost   two inside tests for each instance whose box contains the point.
    bool contain(const Vec3f& point, std::size_t instance) const;

private:
    struct Solid {
        std::size_t instance;
        Placement placement;
        const EntityOcclusion* occlusion;
    };
    std::vector<Solid> solids_;
    InstanceGrid grid_;  ///< Of their spheres.
};

/// Marks the buried vertices of an instance (LocalSamples::buried), and those that lie inside another one.
///
/// samples  of a mesh of the instance's entity.
/// returns  by vertex: 1 where it is buried.
std::vector<std::uint8_t> buried_vertices(const PlacedSolids& solids, const ShadedScene& scene,
                                          std::size_t instance, const LocalSamples& samples);

}  // namespace haarfield
