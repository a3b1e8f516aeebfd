#pragma once
/// What a vertex sees past all objects.

#include "shading/visibility/seen_visibility.h"
#include "shading/visibility/shading_geometry.h"
#include "shading/walk/vertex_shading.h"

namespace haarfield {

/// What a vertex sees past its own and all other instances.
///
/// What is seen exactly is so as cones if it has few triangles, and else rasterized, all of it into one
/// cubemap; if that is chosen automatically, no more than the eight nearest, by their share of the distance
/// within which they are to be, so that a crowd has a bounded cost. What is far is hidden by impostors, in
/// the same cubemap. Instances that are out of reach, or lie below the vertex's horizon, cost nothing but
/// their place in the grid's cell.
///
/// Holds its memory: nothing is allocated per vertex once it has grown.
class VertexVisibility {
public:
    static constexpr std::size_t no_instance = ~std::size_t(0);  ///< The number of none.

    /// rasterizes  false: Occlusion::fields, whatever the geometry was made for.
    /// without     an instance that is not there.
    VertexVisibility(const ShadedScene& scene, const ShadingGeometry& geometry, bool rasterizes = true,
                     std::size_t without = no_instance)
        : scene_(scene),
          geometry_(geometry),
          rasterizes_(rasterizes),
          without_(without),
          seen_(geometry.face_size) {}

    /// Looks round from a point of an instance; false if it is inside another instance and sees nothing.
    ///
    /// point  in the entity's frame; `view` is its view.
    bool look(std::size_t instance, const SurfacePoint& point, const VertexView& view);

    /// The same from a vertex: faster, by the tree of its own visibility, unless the instance is turned.
    bool look(std::size_t instance, std::uint32_t vertex, const VertexView& view);

    /// From the point looked from last; valid until the next look.
    VertexSight sight() const { return {trees_, cones_}; }

    /// Of these trees, the one that was made for the vertex; null: there is none.
    const WideCubemap<std::uint8_t>* made() const { return is_made_ ? &seen_.faces() : nullptr; }
    /// Of the tree that was made for the vertex.
    std::span<const WideNode<std::uint8_t>> made_nodes() const { return seen_.nodes(); }

private:
    /// An instance to be rasterized.
    struct Candidate {
        float distance;  ///< See InstanceSight.
        std::uint32_t instance;
    };

    void clear(const VertexView& view);
    bool look_past_others(std::size_t instance, const VertexView& view);
    /// Takes an instance into account, or adds it to the candidates; false if the vertex is inside of it.
    bool look_past(std::uint32_t instance, const VertexView& view);
    void look_up(const ShadedInstance& other, const VertexView& view);
    void look_from_afar(std::uint32_t instance, const VertexView& view);
    void choose_candidates(const VertexView& view);
    void rasterize(std::uint32_t instance, const VertexView& view);
    void add_tree(const WideCubemap<std::uint8_t>& tree, float weight);

    const ShadedScene& scene_;
    const ShadingGeometry& geometry_;
    const bool rasterizes_;
    const std::size_t without_;
    std::vector<WeightedTrees<std::uint8_t>> trees_;
    std::vector<WeightedTrees<std::uint8_t>::Part> parts_;
    BlockedConeList cones_;
    std::vector<Candidate> candidates_;
    std::vector<OccluderView> rasterized_;  ///< At the vertex at hand,
    std::vector<std::uint32_t> distant_;    ///< and the instances that it sees by impostors.
    SeenVisibility seen_;
    bool is_made_ = false;  ///< Of `seen_`, a tree for the vertex at hand.
};

}  // namespace haarfield
