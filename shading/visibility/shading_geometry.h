#pragma once
/// What shading prepares once for a scene's objects, whatever the light and the view.

#include "shading/scene/shaded_scene.h"
#include "shading/scene/vertex_loop.h"
#include "shading/visibility/buried_fill.h"
#include "shading/visibility/instance_grid.h"
#include "shading/visibility/shadow_rays.h"
#include "shading/walk/direction_pyramid.h"
#include "shading/walk/near_occluders.h"
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
        /// and from elsewhere; infinite if it has polygons. [m]
        float exact_on_ground, exact_around;
        BuriedFill fill;  ///< Of the fine mesh.
    };
    std::vector<Entity> entities;  ///< As in the scene.
    int face_size;
    std::size_t most_rasterized;  ///< Instances, at a vertex.
    DirectionPyramid directions;
    InstanceGrid grid;  ///< Of the places from which the instances can be seen.
    ShadowRays rays;    ///< For concentrated light.

    /// By entity; see visit_vertices.
    std::vector<std::span<const std::uint32_t>> orders() const;
};

/// How one entity blocks light.
///
/// cost    some 0.1 s a million nodes of the field, on all of oneTBB's threads.
/// errors  interrupted.
Result<ShadingGeometry::Entity> entity_geometry(const ShadedEntity& entity, const RenderSettings& settings,
                                                const Progress& progress = {});

/// The geometry holds for these instances: when they change, the grid must be made anew, and the rays placed.
///
/// cost    that of its entities.
/// errors  interrupted.
Result<ShadingGeometry> shading_geometry(const ShadedScene& scene, const RenderSettings& settings,
                                         const Progress& progress = {});

/// Of the places from which each instance hides anything: to where the samplers of its field fade, or as far
/// as matters if it is seen exactly at any distance. entities: those of the scene.
InstanceGrid influence_grid(const ShadedScene& scene, std::span<const ShadingGeometry::Entity> entities);

/// Where a vertex looks up what it sees past an instance: samples of the instance's field.
struct FieldLookup {
    bool planar;  ///< Whose samples they are: the planar sampler's, for vertices on the instance's ground.
    Interpolation samples;
};
/// The samples of an instance's field that a vertex looks up.
FieldLookup field_lookup(const VisibilityField& field, const ShadedInstance& instance,
                         const VertexView& view);

/// Whether an instance lies below a vertex's horizon, so that it hides nothing from it.
bool is_below_horizon(const ShadedEntity& entity, const ShadedInstance& instance, const VertexView& view);

/// How far a vertex is from an instance over the distance within which it is to see it exactly, squared.
/// Where this is not below 1, be it not a number, it looks it up.
float squared_exact_distance(const ShadingGeometry::Entity& prepared, const VisibilityField& field,
                             const ShadedInstance& instance, const VertexView& view);

}  // namespace haarfield
