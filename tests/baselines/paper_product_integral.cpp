#include "tests/baselines/paper_product_integral.h"

#include <cassert>
#include <cstddef>

namespace haarfield::reference {
namespace {

constexpr std::size_t most_trees = 16;

/// A tree on a square on which it has a node: the paper's augnode with its p_sum.
template <class Real>
struct Present {
    const AugmentedQuadtree<Real>* tree;
    const typename AugmentedQuadtree<Real>::Node* node;
    Real sum;
};

template <class Real>
using Square = std::array<Present<Real>, most_trees>;

/// Both folds on the first n trees of a square with scale factor 2^j `amplitude`. The integral excludes the
/// product of the sums.
template <class Real>
struct RecursiveFold {
    const Square<Real>& trees;
    Real amplitude;

    Real integral(std::size_t n) const {
        if (n == 1) return 0;
        const auto& [tree, node, sum] = trees[n - 1];
        return sum * integral(n - 1) + node->wavelet[0] * wavelet(0, n - 1) +
               node->wavelet[1] * wavelet(1, n - 1) + node->wavelet[2] * wavelet(2, n - 1);
    }

    /// Returns the coefficient of wavelet a in the product.
    Real wavelet(std::size_t a, std::size_t n) const {
        const auto& [tree, node, sum] = trees[n - 1];
        if (n == 1) return node->wavelet[a];
        const std::size_t b = (a + 1) % 3, d = (a + 2) % 3;
        Real sums = 1;
        for (std::size_t i = 0; i + 1 < n; ++i) sums *= trees[i].sum;
        return node->wavelet[a] * sums + sum * wavelet(a, n - 1) +
               amplitude * amplitude * node->wavelet[a] * integral(n - 1) +
               amplitude * (node->wavelet[b] * wavelet(d, n - 1) + node->wavelet[d] * wavelet(b, n - 1));
    }
};

template <class Real>
Real table_integral(const Square<Real>& trees, std::size_t n, Real amplitude) {
    std::array<Real, 3> psi = trees[0].node->wavelet;
    Real phi = 0, sums = trees[0].sum;
    for (std::size_t i = 1; i + 1 < n; ++i) {
        const auto& [tree, node, sum] = trees[i];
        const auto& w = node->wavelet;
        const Real scale = sums + amplitude * amplitude * phi;
        phi = sum * phi + w[0] * psi[0] + w[1] * psi[1] + w[2] * psi[2];
        psi = {w[0] * scale + sum * psi[0] + amplitude * (w[1] * psi[2] + w[2] * psi[1]),
               w[1] * scale + sum * psi[1] + amplitude * (w[0] * psi[2] + w[2] * psi[0]),
               w[2] * scale + sum * psi[2] + amplitude * (w[0] * psi[1] + w[1] * psi[0])};
        sums *= sum;
    }
    const auto& [tree, node, sum] = trees[n - 1];
    return sum * phi + node->wavelet[0] * psi[0] + node->wavelet[1] * psi[1] + node->wavelet[2] * psi[2];
}

/// Returns p_sum of the four children.
template <class Real>
std::array<Real, 4> child_sums(const Present<Real>& present, Real amplitude) {
    const auto& [x, y, diagonal] = present.node->wavelet;
    const Real top = present.sum + amplitude * y, bottom = present.sum - amplitude * y;
    const Real right = amplitude * (x + diagonal), left = amplitude * (x - diagonal);
    return {top + right, top - right, bottom + left, bottom - left};
}

template <class Real>
struct Traversal {
    const PaperVariant& variant;
    Real integral = 0;

    /// traverseaugtrees from line 7 on, for the trees that remain after the ranking of line 6.
    void visit(Real cum, const Square<Real>& trees, std::size_t count, int level, Real amplitude) {
        if (count < 2 || level >= variant.depth) return;
        integral +=
            cum * (variant.fold == PaperFold::table ? table_integral(trees, count, amplitude)
                                                    : RecursiveFold<Real>{trees, amplitude}.integral(count));
        std::array<std::array<Real, 4>, most_trees> sums;
        for (std::size_t i = 0; i < count; ++i) sums[i] = child_sums(trees[i], amplitude);
        for (std::size_t quadrant = 0; quadrant < 4; ++quadrant) {
            Square<Real> present;
            std::size_t present_count = 0;
            Real ended = 1;
            for (std::size_t i = 0; i < count; ++i) {
                const std::int32_t child = trees[i].node->child[quadrant];
                if (child == no_node)
                    ended *= sums[i][quadrant];
                else
                    present[present_count++] = {trees[i].tree, &trees[i].tree->nodes[std::size_t(child)],
                                                sums[i][quadrant]};
            }
            const Real child_cum = variant.cumulation == PaperCumulation::corrected ? cum * ended : ended;
            visit(child_cum, present, present_count, level + 1, 2 * amplitude);
        }
    }
};

}  // namespace

template <class Real>
AugmentedQuadtree<Real> augmented_quadtree(const Quadtree& tree) {
    AugmentedQuadtree<Real> augmented{Real(tree.scaling), {}};
    augmented.nodes.resize(tree.nodes.size());
    std::vector<Real> amplitude(tree.nodes.size(), 1);
    for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
        auto& node = augmented.nodes[i];
        for (std::size_t a = 0; a < 3; ++a) node.wavelet[a] = Real(tree.nodes[i].wavelet[a]) / amplitude[i];
        for (unsigned quadrant = 0; quadrant < 4; ++quadrant) {
            node.child[quadrant] = child_of(tree.nodes[i], quadrant);
            if (node.child[quadrant] != no_node)
                amplitude[std::size_t(node.child[quadrant])] = 2 * amplitude[i];
        }
    }
    return augmented;
}

template <class Real>
Real paper_product_integral(std::span<const AugmentedQuadtree<Real>* const> trees,
                            const PaperVariant& variant) {
    assert(!trees.empty() && trees.size() <= most_trees);
    Square<Real> present;
    std::size_t count = 0;
    Real scaling = 1, ended = 1;
    for (const auto* tree : trees) {
        scaling *= tree->scaling;
        if (tree->nodes.empty())
            ended *= tree->scaling;
        else
            present[count++] = {tree, tree->nodes.data(), tree->scaling};
    }
    Traversal<Real> traversal{variant, scaling};
    traversal.visit(ended, present, count, 0, 1);
    return traversal.integral;
}

double paper_product_integral(std::span<const Quadtree* const> trees, const PaperVariant& variant) {
    std::vector<AugmentedQuadtree<double>> augmented;
    for (const Quadtree* tree : trees) augmented.push_back(augmented_quadtree<double>(*tree));
    std::vector<const AugmentedQuadtree<double>*> pointers;
    for (const auto& tree : augmented) pointers.push_back(&tree);
    return paper_product_integral<double>(pointers, variant);
}

template AugmentedQuadtree<float> augmented_quadtree(const Quadtree&);
template AugmentedQuadtree<double> augmented_quadtree(const Quadtree&);
template float paper_product_integral(std::span<const AugmentedQuadtree<float>* const>, const PaperVariant&);
template double paper_product_integral(std::span<const AugmentedQuadtree<double>* const>,
                                       const PaperVariant&);

}  // namespace haarfield::reference
