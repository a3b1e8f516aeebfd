#pragma once
/// The state of the factors during the walk down n trees, and its memory.

#include <algorithm>

#include "shading/walk/wide_tree.h"

namespace haarfield {

/// A tree that varies on a block, and its weight in a factor.
template <class Cell>
struct WeightedNode {
    const WideNode<Cell>* node;
    float weight;
};

/// A factor that varies on a block:  constant + sum of weight * tree  over the trees that vary there.
struct VaryingFactor {
    float constant;
    std::uint32_t nodes;  ///< Number of trees.
};

/// The factors that vary on a block, with their nodes in sequence.
template <class Cell>
struct VaryingFactors {
    std::vector<VaryingFactor> factors;
    std::vector<WeightedNode<Cell>> nodes;
    std::size_t factor_count = 0, node_count = 0;

    void clear() { factor_count = node_count = 0; }  ///< Removes all factors; keeps the memory.

    /// Reserves memory, so that adding needs no checks.
    void reserve(std::size_t most_factors, std::size_t most_nodes) {
        if (factors.size() < most_factors + 1) factors.resize(most_factors + 1);
        if (nodes.size() < most_nodes + 1) nodes.resize(most_nodes + 1);
    }
    void add_factor() { factors[factor_count++] = {0, 0}; }  ///< Adds a factor without nodes.
    /// Adds a node to the last factor.
    void add_node(const WideNode<Cell>* node, float weight) {
        VaryingFactor& factor = factors[factor_count - 1];
        for (std::size_t i = node_count - factor.nodes; i < node_count; ++i)
            if (nodes[i].node == node) {
                nodes[i].weight += weight;
                return;
            }
        nodes[node_count++] = {node, weight};
        ++factor.nodes;
    }
    /// Completes the last factor. If it has no nodes, removes it and returns false.
    bool set_constant(float constant) {
        factors[factor_count - 1].constant = constant;
        if (factors[factor_count - 1].nodes > 0) return true;
        --factor_count;
        return false;
    }
};

/// The memory of one thread's walks. It grows to the size needed and is kept.
template <class Cell>
struct WalkMemory {
    std::array<VaryingFactors<Cell>, 4> varying;  ///< On the current block, by level.
    VaryingFactors<Cell> next;                    ///< On the next face.
    /// A factor on a block, evaluated for the block's children.
    struct Evaluated {
        alignas(64) std::array<float, wide_cells> constant;  ///< Sum over trees that are constant on a cell.
        unsigned varying;                                    ///< Cells on which the factor varies.
    };
    std::array<std::vector<Evaluated>, 4> evaluated;  ///< By level and factor.
    std::vector<Vec3f> sides;  ///< Sides of nearby occluders, in the frame of the current face.

    /// Reserves memory for a walk with these factors.
    void reserve(std::span<const WeightedTrees<Cell>> factors) {
        std::size_t nodes = 0;
        for (const auto& factor : factors) nodes += factor.parts.size();
        for (auto& level : varying) level.reserve(factors.size(), nodes);
        next.reserve(factors.size(), nodes);
        for (auto& level : evaluated)
            if (level.size() < factors.size()) level.resize(factors.size());
    }
};

/// The values of the factors of a product on a whole face.
struct FaceFactors {
    float constant = 1;  ///< Product of the factors that do not vary on the face.
    float mean = 1;      ///< Product of all factors' means.
};

/// Lists the factors that vary on a face. Parts that share a tree there are merged.
template <class Cell>
FaceFactors list_factors(std::span<const WeightedTrees<Cell>> factors, std::size_t face,
                         VaryingFactors<Cell>& varying) {
    varying.clear();
    FaceFactors result;
    for (const WeightedTrees<Cell>& factor : factors) {
        float constant = factor.constant, mean = constant;
        varying.add_factor();
        for (const auto& part : factor.parts) {
            const WideFace<Cell>& tree = (*part.tree)[face];
            mean += part.weight * tree.mean;
            if (tree.root)
                varying.add_node(tree.root, part.weight * cell_unit<Cell>);
            else
                constant += part.weight * tree.mean;
        }
        result.mean *= mean;
        if (!varying.set_constant(constant)) result.constant *= constant;
    }
    return result;
}

/// The depth to which trees are walked.
struct Depth {
    int levels;   ///< Of wide nodes.
    int average;  ///< Cells over which each factor is averaged on the last level: 1, 4 or 16.

    /// depth: in quadtree levels. face_levels: levels of wide nodes on a face.
    Depth(int depth, int face_levels)
        : levels(std::min((depth + 1) / 2, face_levels)), average(depth < 2 * levels ? 4 : 1) {
        if (levels > 0 || face_levels == 0) return;
        levels = 1;
        average = wide_cells;
    }
};

}  // namespace haarfield
