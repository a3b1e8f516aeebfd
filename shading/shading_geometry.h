#pragma once
/// What shading prepares once for a scene's objects, whatever the light and the view.

#include "shading/buried_fill.h"
#include "shading/direction_pyramid.h"
#include "shading/instance_grid.h"
#include "shading/near_occluders.h"
#include "shading/seen_visibility.h"
#include "shading/shaded_scene.h"
#include "shading/vertex_loop.h"
#include "shading/wide_visibility.h"

namespace haarfield {

/// How the entities of a scene block light.
struct ShadingGeometry {
    struct Entity {
        std::vector<std::uint32_t> order;  ///< Of the fine vertices: neighbours in space are near each other.
        WideVisibility visibility;
        std::vector<ConvexPolygon> polygons;  ///< Of occluders of few triangles; else empty.
        /// Within these distances of the samplers' centres the entity is seen exactly, from its ground plane
        /// and from elsewhere. [m]
        float exact_on_ground, exact_around;
        BuriedFill fill;  ///< Of the fine mesh.
    };
    std::vector<Entity> entities;  ///< As in the scene.
    int face_size;
    std::size_t most_rasterized;  ///< Instances, at a vertex.
    DirectionPyramid directions;
    InstanceGrid grid;  ///< Of the places from which the instances can be seen.
};

/// How one entity blocks light.
///
/// cost    some 0.1 s a million nodes of the field, on all of oneTBB's threads.
/// errors  interrupted.
Result<ShadingGeometry::Entity> entity_geometry(const ShadedEntity& entity, const RenderSettings& settings,
                                                const Progress& progress = {});

/// The geometry holds for these instances: when they change, the grid must be made anew.
///
/// cost    that of its entities.
/// errors  interrupted.
Result<ShadingGeometry> shading_geometry(const ShadedScene& scene, const RenderSettings& settings,
                                         const Progress& progress = {});

/// By instance: beyond this sphere the samplers of its field say that it hides nothing.
std::vector<Sphere> spheres_of_influence(const ShadedScene& scene);

/// Where a vertex looks up what it sees past an instance: samples of the instance's field.
struct FieldLookup {
    bool planar;  ///< Whose samples they are: the planar sampler's, for vertices on the instance's ground.
    Interpolation samples;
};
FieldLookup field_lookup(const VisibilityField& field, const ShadedInstance& instance,
                         const VertexView& view);

/// Whether an instance lies below a vertex's horizon, so that it hides nothing from it.
bool is_below_horizon(const ShadedEntity& entity, const ShadedInstance& instance, const VertexView& view);

/// Whether a vertex is so near an instance that it sees it exactly, and does not look it up.
bool is_seen_exactly(const ShadingGeometry::Entity& prepared, const VisibilityField& field,
                     const ShadedInstance& instance, const VertexView& view);

/// What a vertex sees past its own and all other instances.
///
/// What is seen exactly is so as cones if it has few triangles, and else rasterized, all of it into one
/// cubemap; if that is chosen automatically, no more than the eight nearest, by their share of the distance
/// within which they are to be, so that a crowd has a bounded cost. Instances that are open, or lie below the
/// vertex's horizon, cost nothing but their place in the grid's cell.
///
/// Holds its memory: nothing is allocated per vertex once it has grown.
class VertexVisibility {
public:
    /// rasterizes  false: Occlusion::fields, whatever the geometry was made for.
    VertexVisibility(const ShadedScene& scene, const ShadingGeometry& geometry, bool rasterizes = true)
        : scene_(scene), geometry_(geometry), rasterizes_(rasterizes), seen_(geometry.face_size) {}

    /// Looks round from a point of an instance, of whose own visibility `own` is the tree and must outlive
    /// `trees`; false if it is inside another instance and sees nothing.
    bool look(std::size_t instance, const WideCubemap<std::uint8_t>& own, const VertexView& view);

    /// The same from a vertex.
    bool look(std::size_t instance, std::uint32_t vertex, const VertexView& view) {
        return look(instance, geometry_.entities[scene_.instances[instance].entity].visibility.local(vertex),
                    view);
    }

    std::span<const WeightedTrees<std::uint8_t>> trees() const { return trees_; }  ///< Its own first.
    const BlockedCones& cones() const { return cones_; }

private:
    /// An instance to be rasterized.
    struct Candidate {
        float distance;  ///< Squared, over that within which it is seen exactly.
        std::uint32_t instance;
    };

    /// Takes an instance into account, or adds it to the candidates; false if the vertex is inside of it.
    bool look_past(std::uint32_t instance, const VertexView& view);
    void look_up(const ShadedInstance& other, const VertexView& view);
    void rasterize(const VertexView& view);
    void add_tree(const WideCubemap<std::uint8_t>& tree, float weight);

    const ShadedScene& scene_;
    const ShadingGeometry& geometry_;
    const bool rasterizes_;
    std::vector<WeightedTrees<std::uint8_t>> trees_;
    std::vector<WeightedTrees<std::uint8_t>::Part> parts_;
    BlockedCones cones_;
    std::vector<Candidate> candidates_;
    std::vector<OccluderView> rasterized_;
    SeenVisibility seen_;
};

}  // namespace haarfield
