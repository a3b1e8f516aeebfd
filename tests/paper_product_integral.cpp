#include "tests/paper_product_integral.h"

#include <cmath>

namespace haarfield::reference {
namespace {

/// A tree on one square: normalised wavelet coefficients and the paper's p_sum.
struct AugmentedNode {
    const Quadtree* tree;
    std::int32_t index;  ///< no_node: null.
    double sum;
    double wavelet[3];
};

double wavelet_product(int a, int b, int d, const std::vector<AugmentedNode>& t, std::size_t n, int scale);

/// The part of the integral of t[0] ... t[n-1] over their square that is not the product of their sums.
double integral(const std::vector<AugmentedNode>& t, std::size_t n, int scale) {
    if (n == 1) return 0;
    const AugmentedNode& last = t[n - 1];
    return last.sum * integral(t, n - 1, scale) +
           last.wavelet[0] * wavelet_product(0, 1, 2, t, n - 1, scale) +
           last.wavelet[1] * wavelet_product(1, 0, 2, t, n - 1, scale) +
           last.wavelet[2] * wavelet_product(2, 0, 1, t, n - 1, scale);
}

/// The coefficient of wavelet a in that product.
double wavelet_product(int a, int b, int d, const std::vector<AugmentedNode>& t, std::size_t n, int scale) {
    if (n == 1) return t[0].wavelet[a];
    const AugmentedNode& last = t[n - 1];
    double sums = 1;
    for (std::size_t i = 0; i + 1 < n; ++i) sums *= t[i].sum;
    return last.wavelet[a] * sums + last.sum * wavelet_product(a, b, d, t, n - 1, scale) +
           std::ldexp(1.0, 2 * scale) * last.wavelet[a] * integral(t, n - 1, scale) +
           std::ldexp(1.0, scale) * (last.wavelet[b] * wavelet_product(d, a, b, t, n - 1, scale) +
                                     last.wavelet[d] * wavelet_product(b, a, d, t, n - 1, scale));
}

double table_integral(const std::vector<AugmentedNode>& t, int scale) {
    double phi = 0, sums = t[0].sum;
    double psi[3] = {t[0].wavelet[0], t[0].wavelet[1], t[0].wavelet[2]};
    for (std::size_t i = 1; i < t.size(); ++i) {
        const double* w = t[i].wavelet;
        double next_psi[3];
        for (int a = 0; a < 3; ++a) {
            const int b = (a + 1) % 3, d = (a + 2) % 3;
            next_psi[a] = w[a] * sums + t[i].sum * psi[a] + std::ldexp(1.0, 2 * scale) * w[a] * phi +
                          std::ldexp(1.0, scale) * (w[b] * psi[d] + w[d] * psi[b]);
        }
        phi = t[i].sum * phi + w[0] * psi[0] + w[1] * psi[1] + w[2] * psi[2];
        sums *= t[i].sum;
        for (int a = 0; a < 3; ++a) psi[a] = next_psi[a];
    }
    return phi;
}

struct Traversal {
    PaperFold fold;
    PaperCumulation cumulation;
    double integral_so_far;

    void visit(double cum, const std::vector<AugmentedNode>& trees, int scale) {
        std::vector<AugmentedNode> present;
        double ended = 1;
        for (const AugmentedNode& tree : trees)
            if (tree.index == no_node)
                ended *= tree.sum;
            else
                present.push_back(tree);
        if (present.size() < 2) return;
        cum = cumulation == PaperCumulation::corrected ? cum * ended : ended;
        for (AugmentedNode& tree : present)
            for (std::size_t a = 0; a < 3; ++a)
                tree.wavelet[a] =
                    std::ldexp(double(tree.tree->nodes[std::size_t(tree.index)].wavelet[a]), -scale);
        integral_so_far += cum * (fold == PaperFold::table ? table_integral(present, scale)
                                                           : integral(present, present.size(), scale));
        for (unsigned quadrant = 0; quadrant < 4; ++quadrant) {
            std::vector<AugmentedNode> children = present;
            for (AugmentedNode& tree : children) {
                // sum + 2^scale * (sign * coefficient): 2^(j-1) of the child's scale j.
                for (std::size_t a = 0; a < 3; ++a)
                    tree.sum += std::ldexp(double(wavelet_sign[a][quadrant]) * tree.wavelet[a], scale);
                tree.index = child_of(tree.tree->nodes[std::size_t(tree.index)], quadrant);
            }
            visit(cum, children, scale + 1);
        }
    }
};

}  // namespace

double paper_product_integral(std::span<const Quadtree* const> factors, PaperFold fold,
                              PaperCumulation cumulation) {
    std::vector<AugmentedNode> roots;
    double scaling = 1;
    for (const Quadtree* tree : factors) {
        roots.push_back({tree, tree->nodes.empty() ? no_node : 0, double(tree->scaling), {}});
        scaling *= double(tree->scaling);
    }
    Traversal traversal{fold, cumulation, scaling};
    traversal.visit(1, roots, 0);
    return traversal.integral_so_far;
}

}  // namespace haarfield::reference
