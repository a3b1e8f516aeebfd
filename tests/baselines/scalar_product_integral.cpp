#include "tests/baselines/scalar_product_integral.h"

#include <array>
#include <cassert>
#include <cstddef>

namespace haarfield::reference {
namespace {

inline constexpr std::size_t most_factors = 64;

/// A factor on a square on which it varies.
template <class Value>
struct Varying {
    const typename BasicQuadtree<Value>::Node* nodes;  ///< The nodes of the tree.
    /// The node of the square; null if the factor is constant.
    const typename BasicQuadtree<Value>::Node* node;
    Value mean;  ///< Over the square.
};

bool is_zero(float value) {
    return value == 0;
}
bool is_zero(const Rgb& value) {
    return value.x == 0 && value.y == 0 && value.z == 0;
}

template <class Value>
Varying<Value> on_unit_square(const BasicQuadtree<Value>& tree) {
    return {tree.nodes.data(), tree.nodes.empty() ? nullptr : tree.nodes.data(), tree.scaling};
}

template <class Value>
Varying<Value> on_quadrant(const Varying<Value>& factor, unsigned quadrant) {
    const std::int32_t child = child_of(*factor.node, quadrant);
    return {factor.nodes, child == no_node ? nullptr : factor.nodes + child,
            quadrant_mean(factor.mean, factor.node->wavelet, quadrant)};
}

/// Returns the mean over a square of light * factors[0] * ... * factors[count - 1]. Every factor varies
/// there, and light may vary. `levels` is the number of levels of nodes that may still be used.
///
/// If fewer than two of them vary, the mean of the product is the product of the means: a function times
/// constants averages to its mean times the constants. Otherwise, the mean is that of the four quadrants'
/// means. A factor that becomes constant in a quadrant leaves the list there and becomes one number. If that
/// is zero, the quadrant is finished.
template <class Value>
Value square_mean(const Varying<Value>& light, const Varying<float>* factors, std::size_t count, int levels) {
    if (levels == 0 || count + (light.node ? 1 : 0) < 2) {
        Value product = light.mean;
        for (std::size_t i = 0; i < count; ++i) product = product * factors[i].mean;
        return product;
    }
    Value sum(0.0f);
    for (unsigned quadrant = 0; quadrant < 4; ++quadrant) {
        std::array<Varying<float>, most_factors> varying;
        std::size_t varying_count = 0;
        float constant = 1;
        for (std::size_t i = 0; i < count; ++i) {
            const Varying<float> factor = on_quadrant(factors[i], quadrant);
            if (factor.node)
                varying[varying_count++] = factor;
            else
                constant *= factor.mean;
        }
        if (constant == 0) continue;
        const Varying<Value> quadrant_light = light.node ? on_quadrant(light, quadrant) : light;
        if (!quadrant_light.node && is_zero(quadrant_light.mean)) continue;
        sum = sum + square_mean(quadrant_light, varying.data(), varying_count, levels - 1) * constant;
    }
    return sum * 0.25f;
}

/// `factor(i)` returns the i-th of `count` trees.
template <class Value, class Factor>
Value integral(const BasicQuadtree<Value>& light_tree, std::size_t count, const Factor& factor, int depth) {
    assert(count <= most_factors && depth >= 0);
    std::array<Varying<float>, most_factors> varying;
    std::size_t varying_count = 0;
    float constant = 1;
    for (std::size_t i = 0; i < count; ++i) {
        const Quadtree& tree = factor(i);
        if (tree.nodes.empty())
            constant *= tree.scaling;
        else
            varying[varying_count++] = on_unit_square(tree);
    }
    const Varying<Value> light = on_unit_square(light_tree);
    if (constant == 0 || (!light.node && is_zero(light.mean))) return Value(0.0f);
    return square_mean(light, varying.data(), varying_count, depth) * constant;
}

}  // namespace

float scalar_product_integral(std::span<const Quadtree* const> factors, int depth) {
    assert(!factors.empty() && factors.size() <= most_factors);
    const auto others = factors.subspan(1);
    return integral(
        *factors[0], others.size(), [&](std::size_t i) -> const Quadtree& { return *others[i]; }, depth);
}

Rgb scalar_product_integral(const RgbQuadtree& light, std::span<const Quadtree* const> factors, int depth) {
    return integral(
        light, factors.size(), [&](std::size_t i) -> const Quadtree& { return *factors[i]; }, depth);
}

Rgb scalar_product_integral(const RgbCubemapTree& light, std::span<const CubemapTree* const> factors,
                            int depth) {
    Rgb sum(0.0f);
    for (std::size_t face = 0; face < cubemap_faces; ++face)
        sum = sum + integral(
                        light.faces[face], factors.size(),
                        [&](std::size_t i) -> const Quadtree& { return factors[i]->faces[face]; }, depth);
    return sum;
}

}  // namespace haarfield::reference
