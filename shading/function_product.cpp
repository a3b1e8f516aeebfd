#include "shading/function_product.h"

#include <array>
#include <cassert>
#include <cstddef>

namespace haarfield {
namespace {

bool is_zero(float value) {
    return value == 0;
}
bool is_zero(const Rgb& value) {
    return value.x == 0 && value.y == 0 && value.z == 0;
}

/// A scalar factor on a square where it varies.
struct Varying {
    std::size_t factor;  ///< Which.
    std::int32_t node;   ///< The square's.
    float mean;          ///< Over the square.
};

/// A square of the product's tree that has a node: what its factors are there.
template <class Value>
struct Square {
    std::size_t first, count;  ///< Its scalar factors that vary, in a list shared by the level.
    std::int32_t light_node;   ///< Or no_node, where light is constant.
    Value light_mean;
    float constant;  ///< The product of the scalar factors that do not vary.
};

template <class Value>
BasicQuadtree<Value> product(const BasicQuadtree<Value>& light, std::span<const Quadtree* const> factors,
                             int depth) {
    assert(factors.size() <= 64 && depth >= 0);
    BasicQuadtree<Value> result;
    std::vector<Varying> varying, next_varying;
    std::vector<Square<Value>> row, next_row;

    // Takes a square whose varying factors are list[first, end): it gets a node, or it is done and the mean
    // of the product on it is known.
    const auto settle = [&](std::vector<Square<Value>>& squares, std::vector<Varying>& list,
                            std::size_t first, std::int32_t light_node, Value light_mean, float constant,
                            bool deeper, Value& mean) {
        const bool zero = constant == 0 || (light_node == no_node && is_zero(light_mean));
        const bool settled = light_node == no_node && list.size() == first;
        if (deeper && !zero && !settled) {
            squares.push_back({first, list.size() - first, light_node, light_mean, constant});
            return true;
        }
        mean = Value(0.0f);
        if (!zero) {
            mean = light_mean * constant;
            for (std::size_t i = first; i < list.size(); ++i) mean = mean * list[i].mean;
        }
        list.resize(first);
        return false;
    };

    float root_constant = 1;
    for (std::size_t i = 0; i < factors.size(); ++i) {
        if (factors[i]->nodes.empty())
            root_constant *= factors[i]->scaling;
        else
            varying.push_back({i, 0, factors[i]->scaling});
    }
    settle(row, varying, 0, light.nodes.empty() ? no_node : 0, light.scaling, root_constant, depth > 0,
           result.scaling);

    // Down: which squares have nodes; a node's wavelets are not known yet, so that the means of its
    // quadrants are kept beside it.
    std::vector<std::array<Value, 4>> quadrant_means;
    for (int level = 0; !row.empty(); ++level) {
        next_row.clear();
        next_varying.clear();
        const std::size_t next_first = result.nodes.size() + row.size();
        for (const Square<Value>& square : row) {
            std::uint32_t mask = 0;
            const std::size_t first_child = next_first + next_row.size();
            std::array<Value, 4> means;
            means.fill(Value(0.0f));
            for (unsigned quadrant = 0; quadrant < 4; ++quadrant) {
                const std::size_t first = next_varying.size();
                float constant_here = square.constant;
                for (std::size_t i = square.first; i < square.first + square.count; ++i) {
                    const auto& nodes = factors[varying[i].factor]->nodes;
                    const Quadtree::Node& node = nodes[std::size_t(varying[i].node)];
                    const float mean = quadrant_mean(varying[i].mean, node.wavelet, quadrant);
                    const std::int32_t child = child_of(node, quadrant);
                    if (child == no_node)
                        constant_here *= mean;
                    else
                        next_varying.push_back({varying[i].factor, child, mean});
                }
                std::int32_t light_child = no_node;
                Value light_mean = square.light_mean;
                if (square.light_node != no_node) {
                    const auto& node = light.nodes[std::size_t(square.light_node)];
                    light_child = child_of(node, quadrant);
                    light_mean = quadrant_mean(light_mean, node.wavelet, quadrant);
                }
                if (settle(next_row, next_varying, first, light_child, light_mean, constant_here,
                           level + 1 < depth, means[quadrant]))
                    mask |= 1u << quadrant;
            }
            typename BasicQuadtree<Value>::Node node;
            if (mask != 0) node.children = static_cast<std::uint32_t>(first_child << 4 | mask);
            result.nodes.push_back(node);
            quadrant_means.push_back(means);
        }
        row.swap(next_row);
        varying.swap(next_varying);
    }

    // Up: children come after their parents, so that the means of a node's quadrants are complete.
    std::vector<Value> node_means(result.nodes.size());
    for (std::size_t i = result.nodes.size(); i-- > 0;) {
        auto& node = result.nodes[i];
        auto& mean = quadrant_means[i];
        for (unsigned quadrant = 0; quadrant < 4; ++quadrant)
            if (const std::int32_t child = child_of(node, quadrant); child != no_node)
                mean[quadrant] = node_means[std::size_t(child)];
        node.wavelet[0] = ((mean[0] - mean[1]) + (mean[2] - mean[3])) * 0.25f;
        node.wavelet[1] = ((mean[0] + mean[1]) - (mean[2] + mean[3])) * 0.25f;
        node.wavelet[2] = ((mean[0] - mean[1]) - (mean[2] - mean[3])) * 0.25f;
        node_means[i] = ((mean[0] + mean[1]) + (mean[2] + mean[3])) * 0.25f;
    }
    if (!node_means.empty()) result.scaling = node_means[0];
    return result;
}

/// Of the parts of f and g below a square, relative to the square's area.
template <class Value>
Value inner_product_below(const BasicQuadtree<Value>& f, std::int32_t f_index, const Quadtree& g,
                          std::int32_t g_index) {
    const auto& f_node = f.nodes[std::size_t(f_index)];
    const auto& g_node = g.nodes[std::size_t(g_index)];
    Value sum = f_node.wavelet[0] * g_node.wavelet[0] + f_node.wavelet[1] * g_node.wavelet[1] +
                f_node.wavelet[2] * g_node.wavelet[2];
    Value below(0.0f);
    for (unsigned quadrant = 0; quadrant < 4; ++quadrant) {
        const std::int32_t f_child = child_of(f_node, quadrant), g_child = child_of(g_node, quadrant);
        if (f_child != no_node && g_child != no_node)
            below = below + inner_product_below(f, f_child, g, g_child);
    }
    return sum + below * 0.25f;
}

template <class Value>
Value full_inner_product(const BasicQuadtree<Value>& f, const Quadtree& g) {
    const Value means = f.scaling * g.scaling;
    if (f.nodes.empty() || g.nodes.empty()) return means;
    return means + inner_product_below(f, 0, g, 0);
}

}  // namespace

Quadtree function_product(std::span<const Quadtree* const> factors, int depth) {
    assert(!factors.empty());
    return product(*factors[0], factors.subspan(1), depth);
}

RgbQuadtree function_product(const RgbQuadtree& light, std::span<const Quadtree* const> factors, int depth) {
    return product(light, factors, depth);
}

float inner_product(const Quadtree& f, const Quadtree& g) {
    return full_inner_product(f, g);
}

Rgb inner_product(const RgbQuadtree& f, const Quadtree& g) {
    return full_inner_product(f, g);
}

}  // namespace haarfield
