#pragma once
/// The joint visibility of a vertex around its own and all other instances.

#include <optional>

#include "shading/visibility/distant_groups.h"
#include "shading/visibility/rasterized_visibility.h"
#include "shading/visibility/shading_geometry.h"
#include "shading/walk/vertex_shading.h"

namespace haarfield {

/// Evaluates the visibility of vertices and surface points.
///
/// Instances that are evaluated exactly become cones if they have few triangles. Otherwise all of them are
/// rasterized into one cubemap. With Occlusion::automatic at most eight are rasterized: those that are
/// nearest, relative to the distance within which they are exact. This bounds the cost in a crowd. The same
/// mode rasterizes simplifications of those that are far enough away (occluder_for). Distant instances
/// multiply the same cubemap by their impostors. Among 16 instances or more, impostors replace all but the
/// nearest, and groups of distant ones have a tree of their own (DistantGroups). Instances that are out of
/// reach, or below the vertex's horizon, cost only a lookup.
///
/// The instances must stay in place. Reuses its memory: allocates little per vertex once it has grown.
class VertexVisibility {
public:
    static constexpr std::size_t no_instance = ~std::size_t(0);  ///< The index of no instance.

    /// rasterizes  false: evaluates as with Occlusion::fields, for any mode of the geometry.
    /// without     an instance to be ignored.
    VertexVisibility(const ShadedScene& scene, const ShadingGeometry& geometry, bool rasterizes = true,
                     std::size_t without = no_instance)
        : scene_(scene),
          geometry_(geometry),
          rasterizes_(rasterizes),
          without_(without),
          seen_(geometry.face_size) {
        if (geometry.is_crowd) groups_.emplace(scene, geometry, without);
    }

    /// Evaluates the visibility at a point of an instance. Returns false if the point is inside another
    /// instance, where all directions are blocked.
    ///
    /// surface  in the entity's frame; `point` is the same point in the world.
    bool look(std::size_t instance, const SurfacePoint& surface, const ShadingPoint& point);

    /// Evaluates the visibility at a vertex. Faster than for a point, as it uses the tree of the vertex's
    /// local visibility unless the instance is rotated or its field has no local samples.
    bool look(std::size_t instance, std::uint32_t vertex, const ShadingPoint& point);

    /// Returns the visibility that was evaluated last; valid until the next evaluation.
    VisibilityProduct visibility() const { return {trees_, cones_}; }

    /// A tree of `visibility` that was made for the vertex or for a part of space around it.
    struct Made {
        const TexelTree* tree;
        std::uint64_t number;  ///< Not 0: trees of this number are equal.
    };
    /// Returns these trees of `visibility`.
    std::span<const Made> made() const { return made_; }

private:
    /// An instance to be rasterized.
    struct Candidate {
        float distance;  ///< See InstanceOcclusion.
        std::uint32_t instance;
    };

    void clear(const ShadingPoint& point);
    void add_made(const TexelTree& tree, std::uint64_t number);
    bool add_occlusion_by_others(std::size_t instance, const ShadingPoint& point);
    /// Adds an instance as cones, samples or impostors, or to the candidates. Returns false if the vertex is
    /// inside it.
    bool add_occlusion_by(std::uint32_t instance, const ShadingPoint& point);
    void look_up(const ShadedInstance& other, const ShadingPoint& point);
    void add_impostor(std::uint32_t instance, const ShadingPoint& point);
    void choose_candidates(const ShadingPoint& point);
    void rasterize(std::uint32_t instance, const ShadingPoint& point);
    void add_tree(const WideCubemap<std::uint8_t>& tree, float weight);

    const ShadedScene& scene_;
    const ShadingGeometry& geometry_;
    const bool rasterizes_;
    const std::size_t without_;
    std::vector<WeightedTrees<std::uint8_t>> trees_;
    std::vector<WeightedTrees<std::uint8_t>::Part> parts_;
    BlockedConeList cones_;
    std::vector<Candidate> candidates_;
    std::vector<OccluderView> rasterized_;  ///< At the current vertex.
    std::vector<std::uint32_t> distant_;    ///< Instances evaluated by impostors.
    RasterizedVisibility seen_;
    std::optional<DistantGroups> groups_;
    DistantGroups::Surroundings around_;
    std::vector<Made> made_;
};

}  // namespace haarfield
