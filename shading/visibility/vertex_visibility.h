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

    /// From the point looked from last, with its own entity's tree first; valid until the next look.
    VertexSight sight() const { return {trees_, cones_}; }

    /// Of these trees, the one that was rasterized, with its nodes; null: none was.
    const WideCubemap<std::uint8_t>* rasterized() const {
        return rasterized_.empty() ? nullptr : &seen_.faces();
    }
    /// Of the trees that were rasterized at the vertex.
    std::span<const WideNode<std::uint8_t>> rasterized_nodes() const { return seen_.nodes(); }

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
    BlockedConeList cones_;
    std::vector<Candidate> candidates_;
    std::vector<OccluderView> rasterized_;  ///< At the vertex at hand.
    SeenVisibility seen_;
};

}  // namespace haarfield
