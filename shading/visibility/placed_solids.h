#pragma once
/// The closed pieces of a scene's instances, and the colours of vertices inside of them.

#include <optional>
#include <vector>

#include "shading/scene/vertex_loop.h"
#include "shading/visibility/buried_fill.h"
#include "shading/visibility/instance_grid.h"

namespace haarfield {

/// The instances that have closed pieces, as they are placed.
///
/// The occlusion of the entities must outlive it. Safe to share between threads.
class PlacedSolids {
public:
    /// cost  that of an InstanceGrid.
    explicit PlacedSolids(const ShadedScene& scene);

    /// Tests whether a point lies inside another instance than its own: inside the closed pieces of its
    /// original mesh, or of its coarse mesh, where the point would be black.
    ///
    /// point  in the world. [m]
    /// cost   two inside tests for each instance whose box contains the point.
    bool contain(const Vec3f& point, std::size_t instance) const;
    /// Tests whether a surface point lies inside another instance.
    bool contain(const ShadedScene& scene, std::size_t instance, const SurfacePoint& point) const;

    /// Marks the buried vertices of a mesh, and those inside other instances.
    ///
    /// mesh, samples  of the instance: its fine mesh or another one of its entity.
    /// returns        by vertex: 1 if marked.
    std::vector<std::uint8_t> buried_vertices(const ShadedScene& scene, std::size_t instance,
                                              const Mesh& mesh, const LocalSamples& samples) const;

private:
    struct Solid {
        std::size_t instance;
        Placement placement;
        const EntityOcclusion* occlusion;
    };
    static std::vector<Solid> solids(const ShadedScene& scene);
    static std::vector<Sphere> spheres(std::span<const Solid> solids);

    std::vector<Solid> solids_;
    InstanceGrid grid_;  ///< Of their spheres.
};

/// Extrapolates radiance to vertices inside other instances. They are black, and parts of their triangles may
/// be visible: at the feet of a chair on a floor, these parts would be dark teeth.
class PlacedFill {
public:
    PlacedFill() = default;
    /// Finds the vertices of the fine meshes for the current placements.
    ///
    /// cost  that of PlacedSolids::buried_vertices, and of BuriedFill where vertices are inside.
    explicit PlacedFill(const ShadedScene& scene);

    /// Fills in values by instance and vertex. Does nothing where no vertex lies inside another instance.
    template <class Value>
    void operator()(std::vector<std::vector<Value>>& values) const {
        for (std::size_t i = 0; i < fills_.size(); ++i)
            if (fills_[i]) (*fills_[i])(values[i]);
    }

    /// Adds to a selection the vertices from which its vertices are filled.
    void add_sources(VertexMask& is_chosen) const;

private:
    std::vector<std::optional<BuriedFill>> fills_;  ///< By instance.
};

}  // namespace haarfield
