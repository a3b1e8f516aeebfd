#pragma once
/// Geometry prepared once for the objects of a scene, independent of light and at.

#include <optional>

#include "fields/rasterizer/visibility_rasterizer.h"
#include "shading/scene/shaded_scene.h"
#include "shading/scene/vertex_loop.h"
#include "shading/visibility/buried_fill.h"
#include "shading/visibility/impostors.h"
#include "shading/visibility/instance_grid.h"
#include "shading/visibility/shadow_rays.h"
#include "shading/walk/blocked_cones.h"
#include "shading/walk/direction_pyramid.h"
#include "shading/walk/wide_visibility.h"

namespace haarfield {

/// The occluders of a scene, prepared for shading.
struct ShadingGeometry {
    /// Data of one entity.
    struct Entity {
        std::vector<std::uint32_t> order;  ///< Fine vertices along a space-filling curve.
        WideVisibility visibility;
        std::vector<ConvexPolygon> polygons;  ///< Of occluders with few triangles; else empty.
        /// Distances from the samplers' centres within which the entity is evaluated exactly, for points on
        /// its ground plane and for others; see adapt_to_light. [m]
        float exact_on_ground = 0, exact_around = 0;
        BuriedFill fill;  ///< Of the fine mesh.
        /// A simplification of the coarse occluder, for distant points.
        struct Level {
            Occluder occluder;
            float nearest;  ///< Least distance from the occluder's sphere, in the entity's frame. [m]
        };
        std::optional<std::vector<Level>>
            levels;  ///< Finer ones first; made when several instances are placed.
    };
    std::vector<Entity> entities;  ///< In the scene's order.
    int face_size;
    std::size_t most_rasterized;  ///< Instances rasterized per vertex.
    float reach;                  ///< RenderSettings::reach.
    bool simplifies;              ///< Entity::levels are made: with Occlusion::automatic.
    bool is_crowd = false;        ///< So many instances that impostors replace all but the nearest.
    DirectionPyramid directions;

    /// Data of one instance.
    struct Instance {
        std::vector<ConvexPolygon> polygons;  ///< Entity::polygons, rotated.
        bool is_turned;
        Vec3f middle;          ///< Centre of its bounding sphere, in the world. [m]
        float radius, nearer;  ///< Radius of this sphere; distance from which impostors replace it. [m]
    };

    /// @name Data of the instances as placed: see place_instances.
    /// @{
    std::vector<Instance> instances;
    std::vector<std::optional<Impostors>> impostors;  ///< By entity; for entities viewed from far enough.
    InstanceGrid grid;                                ///< Finds the instances that may occlude a point.
    ShadowRays rays;                                  ///< For concentrated light.
    std::optional<double> openness;                   ///< See adapt_to_light; computed when it is needed.
    /// @}

    /// Returns the orders by entity; see visit_vertices.
    std::vector<std::span<const std::uint32_t>> orders() const;
};

/// Prepares a scene's geometry. It is valid for the current placements; after a change, call place_instances.
///
/// cost    about 0.1 s per million nodes of the fields, in parallel on oneTBB, and that of place_instances.
/// errors  interrupted.
Result<ShadingGeometry> shading_geometry(const ShadedScene& scene, const RenderSettings& settings,
                                         const Progress& progress = {});

/// Prepares a scene's geometry for light of known unevenness; see adapt_to_light.
Result<ShadingGeometry> shading_geometry(const ShadedScene& scene, const RenderSettings& settings,
                                         double uneven, const Progress& progress = {});

/// Sets the distances within which entities are evaluated exactly. With Occlusion::automatic, the distance is
/// the outer end of the last band of field samples whose error, times the unevenness of the arriving light,
/// exceeds the tolerance. Where less than half of the directions is open on average, as in a room, the
/// arriving light is more uneven than the environment. The geometry is placed as the scene is. An entity
/// whose field has no samples around it is always exact.
///
/// uneven  unevenness() of the light without its sources; for Occlusion::automatic.
/// cost    about 10 ms, the first time after instances were placed; only with Occlusion::automatic.
void adapt_to_light(const ShadedScene& scene, const RenderSettings& settings, double uneven,
                    ShadingGeometry& geometry);

/// Updates the data that depends on the placements of instances.
///
/// cost    that of Impostors for entities that are viewed from far away for the first time, and that of
///         coarser_meshes when a second instance is placed for the first time.
/// errors  interrupted; the geometry is then unchanged.
Result<Done> place_instances(const ShadedScene& scene, ShadingGeometry& geometry,
                             const Progress& progress = {});

/// The samples of an instance's field that a vertex interpolates. The field must be computed for the
/// instance's rotation.
struct FieldLookup {
    bool planar;  ///< True: samples of the planar sampler, for vertices on the instance's ground plane; else
                  ///< of the spherical one.
    Interpolation samples;
};
/// Returns the samples of an instance's field that a vertex interpolates.
FieldLookup field_lookup(const VisibilityField& field, const ShadedInstance& instance,
                         const ShadingPoint& at);

/// Tests whether an instance lies below a vertex's horizon and occludes nothing.
bool is_below_horizon(const ShadedScene& scene, std::size_t instance, const ShadingPoint& at);

/// Returns an instance's own occluder as a point of its surface views it.
///
/// sample  the point's offset from the surface: SurfacePoint::sample.
OccluderView own_view(const ShadedScene& scene, std::size_t instance, const Vec3f& sample,
                      const ShadingPoint& at);

/// Returns the occluder that is rasterized for a point of another instance: EntityOcclusion::coarse, or a
/// simplification of it if the point is far enough away.
///
/// accuracy  the simplification's RMS distance from the coarse mesh subtends at most 0.3 texels.
///           Error of the radiance, RMS over a table and chairs: 0.07 %.
const Occluder& occluder_for(const ShadedScene& scene, const ShadingGeometry& geometry, std::size_t instance,
                             const ShadingPoint& at);

/// Returns an instance's coarse occluder as a point of another instance views it, without a horizon.
OccluderView view_of(const ShadedScene& scene, std::size_t instance, const ShadingPoint& at);

/// The representation by which a vertex evaluates an instance.
enum class OcclusionKind : std::uint8_t {
    open,     ///< None: out of reach, or below the vertex's horizon.
    exact,    ///< The occluder itself.
    sampled,  ///< Interpolated samples of its field.
    distant,  ///< Impostors.
};
/// The representation of an instance for a vertex.
struct InstanceOcclusion {
    OcclusionKind visibility;
    /// For OcclusionKind::exact: the squared ratio of its distance to the distance within which it is exact.
    float distance = 0;
};

/// Returns the representation by which a vertex evaluates an instance.
InstanceOcclusion occlusion_of(const ShadedScene& scene, const ShadingGeometry& geometry,
                               std::size_t instance, const ShadingPoint& at);

}  // namespace haarfield
