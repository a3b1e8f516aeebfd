#pragma once
/// Quadtrees with two levels per node, like wide bounding volume hierarchies: the data that the product
/// engine walks.
///
/// A node divides its square into 4 x 4 cells and stores the mean of f over each. Cells are in order of
/// quadrants of quadrants (quadtree.h): cell 4 Q + q is quadrant q of quadrant Q. A texel's path of cells
/// from the root is therefore its Morton index in base 16. A function on a face of 64 x 64 texels has at most
/// three levels of nodes.

#include "fields/wavelets/quadtree.h"

#include <memory>

namespace haarfield {

inline constexpr std::size_t wide_cells = 16;  ///< Cells per node.

/// Walk depth that includes all levels of the trees.
inline constexpr int full_depth = 32;

/// A node of a wide tree. Cell: float, or std::uint8_t for functions in [0, 1], in units of 1/255.
template <class Cell>
struct WideNode {
    std::array<Cell, wide_cells> mean{};  ///< Mean of f over each cell. [f]
    std::uint32_t first_child = 0;        ///< Distance from this node to its first child, in nodes.
    std::uint16_t varying = 0;            ///< Bit mask of the cells that have a child; f is constant on the
                                          ///< others. Children are contiguous, by cell.
};

/// The value of a cell of 1.
template <class Cell>
inline constexpr float cell_unit = 1;
template <>
inline constexpr float cell_unit<std::uint8_t> = 1.0f / 255;

/// Converts a value in [0, 1] to units of 1/255, rounded.
constexpr std::uint8_t in_bytes(float value) {
    return static_cast<std::uint8_t>(value * 255 + 0.5f);
}

/// A function on one face.
template <class Cell>
struct WideFace {
    const WideNode<Cell>* root = nullptr;  ///< Null: f is constant.
    float mean = 0;                        ///< Mean of f. [f]
    std::uint32_t nodes = 0;               ///< Number of contiguous nodes from the root; 0: unknown.
};

/// A function of direction, by face.
template <class Cell>
using WideCubemap = std::array<WideFace<Cell>, cubemap_faces>;

/// A function of direction as a sum:  constant + sum of weight * tree. A single tree has constant 0 and
/// weight 1. A visibility interpolated between samples has their weights; its constant is the weight of
/// unoccluded samples.
template <class Cell>
struct WeightedTrees {
    /// A tree and its weight.
    struct Part {
        const WideCubemap<Cell>* tree;
        float weight;
    };
    float constant = 0;
    std::span<const Part> parts;
};

/// Returns a node's child in a varying cell.
template <class Cell>
const WideNode<Cell>* child_of(const WideNode<Cell>* node, unsigned cell) {
    const unsigned before = node->varying & ((1u << cell) - 1u);
    return node + node->first_child + std::popcount(before);
}

/// Returns the number of levels of wide nodes down to texels: 3 for a face of 64.
constexpr int wide_levels(int face_size) {
    return (std::countr_zero(unsigned(face_size)) + 1) / 2;
}

/// Appends a tree's nodes to `nodes`, root first, children after their parents. Returns false if the tree is
/// constant.
///
/// accuracy  means are exact up to rounding. Means below 5e-7 of the L2 norm of f are rounding errors and set
///           to zero, so that the walk can skip everything below them.
/// cost      O(nodes).
bool append_wide_nodes(const Quadtree& tree, std::vector<WideNode<float>>& nodes);

/// A function of direction that owns its nodes. It may be moved while factors refer to it.
class WideCubemapTree {
public:
    /// cost: O(nodes).
    explicit WideCubemapTree(const CubemapTree& tree);

    const WideCubemap<float>& faces() const { return trees_->faces; }  ///< As a part of a weighted sum.

    /// Returns the function as a factor of a product. The tree must outlive the factor.
    WeightedTrees<float> factor() const& { return {0, {&trees_->whole, 1}}; }
    WeightedTrees<float> factor() && = delete;

private:
    struct Trees {
        std::vector<WideNode<float>> nodes;
        WideCubemap<float> faces;
        WeightedTrees<float>::Part whole{&faces, 1};
    };
    std::unique_ptr<const Trees> trees_;
};

}  // namespace haarfield
