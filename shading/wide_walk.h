#pragma once
/// What the walk down n trees keeps of the factors, and its memory.

#include <cassert>

#include "shading/wide_tree.h"

namespace haarfield {

/// A tree that varies on a block, and its weight in the factor.
template <class Cell>
struct WeightedNode {
    const WideNode<Cell>* node;
    float weight;
};

/// A factor that varies on a block:  constant + sum of weight * tree  over its trees that do.
struct VaryingFactor {
    float constant;
    std::uint32_t nodes;  ///< How many.
};

/// The factors that vary on one block; their nodes one after the other.
template <class Cell>
struct VaryingFactors {
    std::vector<VaryingFactor> factors;
    std::vector<WeightedNode<Cell>> nodes;
    std::size_t factor_count = 0, node_count = 0;

    void clear() { factor_count = node_count = 0; }

    /// Room for so many, so that adding need not look.
    void reserve(std::size_t most_factors, std::size_t most_nodes) {
        if (factors.size() < most_factors + 1) factors.resize(most_factors + 1);
        if (nodes.size() < most_nodes + 1) nodes.resize(most_nodes + 1);
    }
    void add_factor() { factors[factor_count++] = {0, 0}; }
    /// To the factor added last.
    void add_node(const WideNode<Cell>* node, float weight) {
        nodes[node_count++] = {node, weight};
        ++factors[factor_count - 1].nodes;
    }
    /// Completes the factor added last; false if it has no nodes: then it is taken from the list.
    bool set_constant(float constant) {
        factors[factor_count - 1].constant = constant;
        if (factors[factor_count - 1].nodes > 0) return true;
        --factor_count;
        return false;
    }
};

/// One thread's memory for a walk; grows to what is needed and stays.
template <class Cell>
struct WalkMemory {
    std::array<VaryingFactors<Cell>, 4> varying;  ///< On the block at hand, by level.
    struct Evaluated {
        alignas(64) std::array<float, wide_cells> constant;  ///< Of the trees that do not vary on a cell.
        unsigned varying;                                    ///< Cells.
    };
    std::array<std::vector<Evaluated>, 4> evaluated;  ///< By level and factor.

    void reserve(std::size_t most_factors, std::size_t most_nodes) {
        for (auto& level : varying) level.reserve(most_factors, most_nodes);
        for (auto& level : evaluated)
            if (level.size() < most_factors) level.resize(most_factors);
    }
};

}  // namespace haarfield
