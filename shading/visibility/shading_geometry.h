#pragma once
/// What shading prepares once for a scene's objects, whatever the light and the view.

#include <memory>
#include <optional>

#include "shading/scene/shaded_scene.h"
#include "shading/scene/vertex_loop.h"
#include "shading/visibility/buried_fill.h"
#include "shading/visibility/impostors.h"
#include "shading/visibility/instance_grid.h"
#include "shading/visibility/placed_solids.h"
#include "shading/visibility/shadow_rays.h"
#include "shading/visibility/turned_occluders.h"
#include "shading/walk/blocked_cones.h"
#include "shading/walk/direction_pyramid.h"
#include "shading/walk/wide_visibility.h"

namespace haarfield {

/// How the entities of a scene block light.
struct ShadingGeometry {
    /// What an entity contributes.
    struct Entity {
        std::vector<std::uint32_t> order;  ///< Of the fine vertices: neighbours in space are near each other.
        WideVisibility visibility;
        std::vector<ConvexPolygon> polygons;  ///< Of occluders of few triangles; else empty.
        /// Within these distances of the samplers' centres the entity is seen exactly, from its ground plane
        /// and from elsewhere; see adapt_to_light. [m]
        float exact_on_ground = 0, exact_around = 0;
        std::shared_ptr<const BuriedFill> fill;  ///< Of the fine mesh.
    };
    std::vector<Entity> entities;  ///< As in the scene.
    int face_size;
    std::size_t most_rasterized;  ///< Instances, at a vertex.
    float reach;                  ///< Of RenderSettings.
    DirectionPyramid directions;

    /// @name By instance, as they are placed: see place_instances. @{
    InstanceOccluders occluders;
    /// What an instance contributes.
    struct Instance {
        std::vector<ConvexPolygon> polygons;  ///< Entity::polygons, turned.
        bool is_turned;
        Vec3f middle;          ///< Of its sphere, in the world. [m]
        float radius, nearer;  ///< Of the sphere; and beyond this distance it is seen by its impostors. [m]
        /// Fills the fine mesh: Entity::fill, or with the vertices inside other instances; see place_solids.
        std::shared_ptr<const BuriedFill> fill;
    };
    std::vector<Instance> instances;
    std::vector<std::optional<Impostors>> impostors;  ///< By entity, of those that are seen from so far.
    InstanceGrid grid;                                ///< Of the places from which the instances can be seen.
    ShadowRays rays;                                  ///< For concentrated light.
    PlacedSolids solids;                              ///< What contains vertices of other instances.
    std::optional<double> openness;                   ///< See adapt_to_light; once it was needed.
    /// @}

    /// By entity; see visit_vertices.
    std::vector<std::span<const std::uint32_t>> orders() const;
};

/// The geometry holds for these instances as they are placed; when they change, see place_instances.
///
/// cost    some 0.1 s a million nodes of the fields, on all of oneTBB's threads, and see place_instances.
/// errors  interrupted.
Result<ShadingGeometry> shading_geometry(const ShadedScene& scene, const RenderSettings& settings,
                                         const Progress& progress = {});

/// The same where the light's unevenness is known; see adapt_to_light.
Result<ShadingGeometry> shading_geometry(const ShadedScene& scene, const RenderSettings& settings,
                                         double uneven, const Progress& progress = {});

/// Decides anew how far out entities are seen exactly. With Occlusion::automatic that is as the light wants
/// it: to the outer end of the last band of their field's samples where the error times the unevenness of the
/// light that arrives is above the tolerance. Where less than half of the directions over the scene is open,
/// as in a room, that is larger than the light's own. The geometry is placed as the scene is.
///
/// uneven  unevenness() of the light without its sources; of Occlusion::automatic.
/// cost    some 10 ms, the first time after instances were placed; only of Occlusion::automatic.
void adapt_to_light(const ShadedScene& scene, const RenderSettings& settings, double uneven,
                    ShadingGeometry& geometry);

/// Makes anew what depends on where the instances stand.
///
/// cost    that of InstanceOccluders, for rotations that are new; and that of Impostors, for entities that
///         were not seen from so far before.
/// errors  interrupted; then the geometry is as it was.
Result<Done> place_instances(const ShadedScene& scene, ShadingGeometry& geometry,
                             const Progress& progress = {});

/// Computes which vertices lie inside other instances: `solids`, and the instances' fills.
///
/// cost  an inside test for each vertex in the box of another instance.
void place_solids(const ShadedScene& scene, ShadingGeometry& geometry);

/// Where a vertex looks up what it sees past an instance: samples of its field, which must be one of the
/// instance as it is turned.
struct FieldLookup {
    bool planar;  ///< Whose samples they are: the planar sampler's, for vertices on the instance's ground.
    Interpolation samples;
};
/// The samples of an instance's field that a vertex looks up.
FieldLookup field_lookup(const VisibilityField& field, const ShadedInstance& instance,
                         const VertexView& view);

/// Whether an instance lies below a vertex's horizon, so that it hides nothing from it.
///
/// coarse  of the instance, as it is turned.
bool is_below_horizon(const Occluder& coarse, const Placement& placement, const VertexView& view);

/// How a vertex sees past an instance.
enum class Sight : std::uint8_t {
    open,     ///< Not at all: it is out of reach, or below the vertex's horizon.
    exact,    ///< Its occluder.
    sampled,  ///< Between samples of its field.
    distant,  ///< By impostors.
};
struct InstanceSight {
    Sight sight;
    /// If it is seen exactly: how far it is, over the distance within which it is so; squared.
    float distance = 0;
};
InstanceSight sight_of(const ShadedScene& scene, const ShadingGeometry& geometry, std::size_t instance,
                       const VertexView& view);

}  // namespace haarfield
