#include "shading/walk/wide_tree.h"

#include <cmath>

namespace haarfield {
namespace {

double l2_norm(const Quadtree& tree) {
    // Nodes are ordered by level: a level ends where the children of its last node end.
    double square = double(tree.scaling) * tree.scaling, share = 1;
    std::size_t level_end = 1, next = 1;
    for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
        if (i == level_end) {
            level_end = next;
            share /= 4;
        }
        const Quadtree::Node& node = tree.nodes[i];
        for (const float wavelet : node.wavelet) square += double(wavelet) * wavelet * share;
        next += std::size_t(std::popcount(node.children & 15u));
    }
    return std::sqrt(square);
}

class WideNodeWriter {
public:
    WideNodeWriter(const Quadtree& tree, std::vector<WideNode<float>>& nodes)
        : tree_(tree), nodes_(nodes), negligible_(static_cast<float>(5e-7 * l2_norm(tree))) {}

    /// Fills nodes[place] from a node of the tree with a given mean, and appends its children.
    void write(std::size_t place, std::int32_t index, float mean) {
        WideNode<float> wide;
        std::array<std::int32_t, wide_cells> below;
        below.fill(no_node);
        const Quadtree::Node& node = tree_.nodes[std::size_t(index)];
        for (unsigned cell = 0; cell < wide_cells; ++cell) {
            const std::int32_t child = child_of(node, cell / 4);
            float value = quadrant_mean(mean, node.wavelet, cell / 4);
            if (child != no_node) {
                const Quadtree::Node& quadrant = tree_.nodes[std::size_t(child)];
                value = quadrant_mean(value, quadrant.wavelet, cell % 4);
                below[cell] = child_of(quadrant, cell % 4);
            }
            if (below[cell] != no_node)
                wide.varying |= static_cast<std::uint16_t>(1u << cell);
            else if (std::abs(value) < negligible_)
                value = 0;
            wide.mean[cell] = value;
        }
        std::size_t child = nodes_.size();
        wide.first_child = static_cast<std::uint32_t>(child - place);
        nodes_[place] = wide;
        nodes_.resize(child + std::size_t(std::popcount(wide.varying)));
        for (unsigned cell = 0; cell < wide_cells; ++cell)
            if (below[cell] != no_node) write(child++, below[cell], wide.mean[cell]);
    }

private:
    const Quadtree& tree_;
    std::vector<WideNode<float>>& nodes_;
    const float negligible_;
};

}  // namespace

bool append_wide_nodes(const Quadtree& tree, std::vector<WideNode<float>>& nodes) {
    if (tree.nodes.empty()) return false;
    nodes.emplace_back();
    WideNodeWriter(tree, nodes).write(nodes.size() - 1, 0, tree.scaling);
    return true;
}

WideCubemapTree::WideCubemapTree(const CubemapTree& tree) {
    auto trees = std::make_unique<Trees>();
    std::array<std::size_t, cubemap_faces> root;
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        root[face] = trees->nodes.size();
        append_wide_nodes(tree.faces[face], trees->nodes);
    }
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        WideFace<float>& wide = trees->faces[face];
        wide.mean = tree.faces[face].scaling;
        if (tree.faces[face].nodes.empty()) continue;
        wide.root = &trees->nodes[root[face]];
        wide.nodes = static_cast<std::uint32_t>(
            (face + 1 < cubemap_faces ? root[face + 1] : trees->nodes.size()) - root[face]);
    }
    trees_ = std::move(trees);
}

}  // namespace haarfield
