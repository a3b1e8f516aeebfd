#pragma once
/// Quadtrees with two levels in a node, as wide bounding volume hierarchies have them: what the product
/// engine walks.
///
/// A node divides its square into 4 x 4 cells and holds the mean of f over each. Cells go by quadrant of
/// quadrant (quadtree.h): cell 4 Q + q is quadrant q of quadrant Q, so that a texel's path of cells from the
/// root is its Morton index in base 16. A function on a face of 64 x 64 texels has at most three levels of
/// nodes.

#include "fields/wavelets/quadtree.h"

#include <memory>

namespace haarfield {

inline constexpr std::size_t wide_cells = 16;  ///< Of a node.

/// A depth of walks: all levels of the trees take part.
inline constexpr int full_depth = 32;

/// Cell: float, or std::uint8_t for functions in [0, 1], counted in 255ths.
template <class Cell>
struct WideNode {
    std::array<Cell, wide_cells> mean{};  ///< Of f over each cell. [f]
    std::uint32_t first_child = 0;        ///< Distance from this node to its first child, in nodes.
    std::uint16_t varying = 0;            ///< Cells that have a child, by bit; f is constant on the others.
                                          ///< Children lie side by side, by cell.
};

/// What a cell of 1 stands for.
template <class Cell>
inline constexpr float cell_unit = 1;
template <>
inline constexpr float cell_unit<std::uint8_t> = 1.0f / 255;

/// A value in [0, 1] in 255ths, rounded.
constexpr std::uint8_t in_bytes(float value) {
    return static_cast<std::uint8_t>(value * 255 + 0.5f);
}

/// Where a function on one face is found.
template <class Cell>
struct WideFace {
    const WideNode<Cell>* root = nullptr;  ///< Null: f is constant.
    float mean = 0;                        ///< Of f. [f]
    std::uint32_t nodes = 0;               ///< So many from the root on, side by side; 0: not known.
};

/// A function of direction, by face.
template <class Cell>
using WideCubemap = std::array<WideFace<Cell>, cubemap_faces>;

/// A function of direction as a sum:  constant + sum of weight * tree. A tree by itself has constant 0 and
/// weight 1; a visibility interpolated between samples has the samples' weights, and the weight of "nothing
/// in the way" as the constant.
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

/// A node's child in a cell that varies.
template <class Cell>
const WideNode<Cell>* child_of(const WideNode<Cell>* node, unsigned cell) {
    const unsigned before = node->varying & ((1u << cell) - 1u);
    return node + node->first_child + std::popcount(before);
}

/// How many levels of wide nodes reach texels: 3 for a face of 64.
constexpr int wide_levels(int face_size) {
    return (std::countr_zero(unsigned(face_size)) + 1) / 2;
}

/// A tree's nodes appended to `nodes`, root first, children after their parents; whether there are any.
///
/// accuracy  means are exact up to rounding; those below 5e-7 of the L2 norm of f, which are rounding, are
///           set to zero, so that the walk can drop what lies under them.
/// cost      O(nodes).
bool append_wide_nodes(const Quadtree& tree, std::vector<WideNode<float>>& nodes);

/// A function of direction that owns its nodes. May be moved while factors refer to it.
class WideCubemapTree {
public:
    /// cost: O(nodes).
    explicit WideCubemapTree(const CubemapTree& tree);

    const WideCubemap<float>& faces() const { return trees_->faces; }  ///< As parts of a sum take it.

    /// The function as a factor of a product, which the tree must outlive.
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
