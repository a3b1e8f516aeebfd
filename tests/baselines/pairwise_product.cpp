#include "tests/baselines/pairwise_product.h"

#include <cassert>
#include <cstddef>
#include <utility>

namespace haarfield::baseline {
namespace {

/// A tree on a square: its node, or no_node if it is constant, and its mean.
struct Place {
    std::int32_t node;
    float mean;
};

Place root_of(const LinkedQuadtree& tree) {
    return {tree.nodes.empty() ? no_node : 0, tree.scaling};
}

std::array<Place, 4> quadrants(const LinkedQuadtree& tree, const Place& square) {
    if (square.node == no_node) return {square, square, square, square};
    const auto& [wavelet, child] = tree.nodes[std::size_t(square.node)];
    const float top = square.mean + wavelet[1], bottom = square.mean - wavelet[1];
    const float right = wavelet[0] + wavelet[2], left = wavelet[0] - wavelet[2];
    return {{{child[0], top + right},
             {child[1], top - right},
             {child[2], bottom + left},
             {child[3], bottom - left}}};
}

/// Appends the product's nodes on a square. Returns its place there.
Place append_product(const LinkedQuadtree& f, const Place& in_f, const LinkedQuadtree& g, const Place& in_g,
                     LinkedQuadtree& product) {
    const bool f_ends = in_f.node == no_node, g_ends = in_g.node == no_node;
    if ((f_ends && g_ends) || (f_ends && in_f.mean == 0) || (g_ends && in_g.mean == 0))
        return {no_node, in_f.mean * in_g.mean};
    const std::size_t index = product.nodes.size();
    product.nodes.emplace_back();
    const std::array<Place, 4> f_parts = quadrants(f, in_f), g_parts = quadrants(g, in_g);
    std::array<Place, 4> parts;
    for (std::size_t q = 0; q < 4; ++q) parts[q] = append_product(f, f_parts[q], g, g_parts[q], product);
    const float top = parts[0].mean + parts[1].mean, bottom = parts[2].mean + parts[3].mean;
    const float top_step = parts[0].mean - parts[1].mean, bottom_step = parts[2].mean - parts[3].mean;
    product.nodes[index] = {{(top_step + bottom_step) / 4, (top - bottom) / 4, (top_step - bottom_step) / 4},
                            {parts[0].node, parts[1].node, parts[2].node, parts[3].node}};
    return {static_cast<std::int32_t>(index), (top + bottom) / 4};
}

/// Returns the inner product of the wavelets of both functions below a square, relative to its area.
Rgb inner_product_below(const RgbQuadtree& light, const RgbQuadtree::Node& light_node,
                        const LinkedQuadtree& f, const LinkedQuadtree::Node& node) {
    Rgb below(0.0f);
    for (unsigned q = 0; q < 4; ++q) {
        if (node.child[q] == no_node) continue;
        const std::int32_t light_child = child_of(light_node, q);
        if (light_child == no_node) continue;
        below += inner_product_below(light, light.nodes[std::size_t(light_child)], f,
                                     f.nodes[std::size_t(node.child[q])]);
    }
    return light_node.wavelet[0] * node.wavelet[0] + light_node.wavelet[1] * node.wavelet[1] +
           light_node.wavelet[2] * node.wavelet[2] + below * 0.25f;
}

}  // namespace

LinkedQuadtree linked_quadtree(const Quadtree& tree) {
    LinkedQuadtree linked{tree.scaling, {}};
    for (const Quadtree::Node& node : tree.nodes)
        linked.nodes.push_back(
            {node.wavelet, {child_of(node, 0), child_of(node, 1), child_of(node, 2), child_of(node, 3)}});
    return linked;
}

void pairwise_product(const LinkedQuadtree& f, const LinkedQuadtree& g, LinkedQuadtree& product) {
    product.nodes.clear();
    product.scaling = append_product(f, root_of(f), g, root_of(g), product).mean;
}

Rgb RecursivePairwiseProduct::operator()(const RgbQuadtree& light,
                                         std::span<const LinkedQuadtree* const> factors) {
    assert(!factors.empty());
    const LinkedQuadtree* product = factors[0];
    for (const LinkedQuadtree* factor : factors.subspan(1)) {
        pairwise_product(*product, *factor, next_);
        std::swap(product_, next_);
        product = &product_;
    }
    Rgb sum = light.scaling * product->scaling;
    if (!light.nodes.empty() && !product->nodes.empty())
        sum += inner_product_below(light, light.nodes[0], *product, product->nodes[0]);
    return sum;
}

}  // namespace haarfield::baseline
