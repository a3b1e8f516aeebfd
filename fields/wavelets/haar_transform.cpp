#include "fields/wavelets/haar_transform.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <functional>

#include "fields/wavelets/largest_by_energy.h"

namespace haarfield {
namespace {

/// The full transform: the mean, and for each level the wavelets of its 4^level squares in row-major order.
template <class Value>
struct FullTransform {
    Value mean;
    std::vector<std::array<Value, 3>> wavelets;  ///< Level l starts at (4^l - 1) / 3.
};

constexpr std::size_t level_offset(int level) {
    return ((std::size_t(1) << (2 * level)) - 1) / 3;
}

template <class Value>
FullTransform<Value> full_transform(std::span<const Value> texels, int size) {
    const int levels = std::countr_zero(unsigned(size));
    FullTransform<Value> result;
    result.wavelets.resize(level_offset(levels));
    std::vector<Value> fine(texels.begin(), texels.end()), coarse;
    for (int level = levels - 1; level >= 0; --level) {
        const std::size_t side = std::size_t(1) << level;
        coarse.resize(side * side);
        for (std::size_t y = 0; y < side; ++y)
            for (std::size_t x = 0; x < side; ++x) {
                const Value* top = &fine[4 * y * side + 2 * x];
                const Value* bottom = top + 2 * side;
                const Value left_top = top[0], right_top = top[1], left_bottom = bottom[0],
                            right_bottom = bottom[1];
                auto& wavelet = result.wavelets[level_offset(level) + y * side + x];
                wavelet[0] = ((left_top - right_top) + (left_bottom - right_bottom)) * 0.25f;
                wavelet[1] = ((left_top + right_top) - (left_bottom + right_bottom)) * 0.25f;
                wavelet[2] = ((left_top - right_top) - (left_bottom - right_bottom)) * 0.25f;
                coarse[y * side + x] = ((left_top + right_top) + (left_bottom + right_bottom)) * 0.25f;
            }
        fine.swap(coarse);
    }
    result.mean = fine[0];
    return result;
}

/// A wavelet and its contribution to the squared L2 norm of the function.
struct Candidate {
    double energy;
    std::uint32_t index;  ///< 3 * square + kind, squares numbered as in FullTransform.
};

/// Sets the wavelets to zero that the truncation drops.
template <class Value>
void truncate(FullTransform<Value>& transform, int levels, const Truncation& truncation) {
    std::vector<Candidate> candidates;
    double norm = squared(transform.mean);
    for (int level = 0; level < levels; ++level) {
        const double share = std::ldexp(1.0, -2 * level);
        for (std::size_t square = level_offset(level); square < level_offset(level + 1); ++square)
            for (std::size_t kind = 0; kind < 3; ++kind) {
                const double energy = squared(transform.wavelets[square][kind]) * share;
                if (energy == 0) continue;
                norm += energy;
                candidates.push_back({energy, static_cast<std::uint32_t>(3 * square + kind)});
            }
    }
    const bool limited =
        truncation.coefficients > 0 && candidates.size() > std::size_t(truncation.coefficients);
    if (!limited && truncation.relative_l2_error <= 0) return;

    // Indices are in level order, so the smaller index is on the coarser level, as ties require.
    const auto matters_more = [](const Candidate& a, const Candidate& b) {
        return a.energy != b.energy ? a.energy > b.energy : a.index < b.index;
    };
    std::size_t kept = candidates.size();
    double dropped = 0;
    if (limited) {
        kept = std::size_t(truncation.coefficients);
        std::nth_element(candidates.begin(), candidates.begin() + truncation.coefficients, candidates.end(),
                         matters_more);
        for (std::size_t i = kept; i < candidates.size(); ++i) dropped += candidates[i].energy;
    }
    if (truncation.relative_l2_error > 0) {
        const double allowed = norm * squared(truncation.relative_l2_error);
        kept = largest_by_energy(
            std::span(candidates).first(kept), allowed - dropped,
            [](const Candidate& candidate) { return candidate.energy; }, matters_more);
    }
    for (std::size_t i = kept; i < candidates.size(); ++i)
        transform.wavelets[candidates[i].index / 3][candidates[i].index % 3] = Value(0.0f);
}

/// Appends the nodes of a face in level order: one for each square with a wavelet in it or below it.
template <class Value>
void append_nodes(const FullTransform<Value>& transform, int levels,
                  std::vector<typename BasicQuadtree<Value>::Node>& nodes) {
    std::vector<std::uint8_t> occupied(transform.wavelets.size(), 0);
    for (int level = levels - 1; level >= 0; --level) {
        const std::size_t side = std::size_t(1) << level;
        for (std::size_t y = 0; y < side; ++y)
            for (std::size_t x = 0; x < side; ++x) {
                const std::size_t square = level_offset(level) + y * side + x;
                bool used = false;
                for (const Value& wavelet : transform.wavelets[square]) used |= squared(wavelet) != 0;
                if (level + 1 < levels)
                    for (std::size_t q = 0; q < 4; ++q)
                        used |=
                            occupied[level_offset(level + 1) + (2 * y + q / 2) * 2 * side + 2 * x + q % 2] !=
                            0;
                occupied[square] = used;
            }
    }
    if (levels == 0 || !occupied[0]) return;

    struct Square {
        std::uint32_t x, y;
    };
    std::vector<Square> row{{0, 0}}, next;
    for (int level = 0; level < levels && !row.empty(); ++level) {
        const std::size_t side = std::size_t(1) << level;
        const std::size_t next_first = nodes.size() + row.size();
        next.clear();
        for (const Square square : row) {
            typename BasicQuadtree<Value>::Node node;
            node.wavelet = transform.wavelets[level_offset(level) + square.y * side + square.x];
            std::uint32_t mask = 0;
            const std::size_t first = next_first + next.size();
            if (level + 1 < levels)
                for (std::uint32_t q = 0; q < 4; ++q) {
                    const Square child{2 * square.x + q % 2, 2 * square.y + q / 2};
                    if (!occupied[level_offset(level + 1) + child.y * 2 * side + child.x]) continue;
                    mask |= 1u << q;
                    next.push_back(child);
                }
            node.children = mask == 0 ? 0 : static_cast<std::uint32_t>(first << 4 | mask);
            nodes.push_back(node);
        }
        row.swap(next);
    }
}

template <class Value>
void fill_texels(const BasicQuadtree<Value>& tree, std::int32_t index, const Value& mean, std::size_t x,
                 std::size_t y, std::size_t side, std::size_t size, std::vector<Value>& texels) {
    if (index == no_node || side == 1) {
        for (std::size_t row = y; row < y + side; ++row)
            for (std::size_t column = x; column < x + side; ++column) texels[row * size + column] = mean;
        return;
    }
    const auto& node = tree.nodes[std::size_t(index)];
    for (unsigned q = 0; q < 4; ++q)
        fill_texels(tree, child_of(node, q), quadrant_mean(mean, node.wavelet, q), x + (q & 1u) * (side / 2),
                    y + (q >> 1) * (side / 2), side / 2, size, texels);
}

}  // namespace

template <class Value>
BasicQuadtree<Value> haar_quadtree(std::span<const Value> texels, int size, const Truncation& truncation) {
    assert(is_face_size(size) && texels.size() == std::size_t(size) * std::size_t(size));
    BasicQuadtree<Value> tree;
    if (std::adjacent_find(texels.begin(), texels.end(), std::not_equal_to<>()) == texels.end()) {
        tree.scaling = texels[0];
        return tree;
    }
    const int levels = std::countr_zero(unsigned(size));
    FullTransform<Value> transform = full_transform(texels, size);
    truncate(transform, levels, truncation);
    tree.scaling = transform.mean;
    append_nodes(transform, levels, tree.nodes);
    return tree;
}

template <class Value>
std::vector<Value> quadtree_texels(const BasicQuadtree<Value>& tree, int size) {
    assert(is_face_size(size));
    std::vector<Value> texels(std::size_t(size) * std::size_t(size));
    fill_texels(tree, tree.nodes.empty() ? no_node : 0, tree.scaling, 0, 0, std::size_t(size),
                std::size_t(size), texels);
    return texels;
}

template <class Value>
BasicQuadtree<Value> weighted_sum(std::span<const BasicQuadtree<Value>* const> trees,
                                  std::span<const float> weights) {
    assert(trees.size() == weights.size() && !trees.empty() && trees.size() <= 16);
    BasicQuadtree<Value> sum;
    sum.scaling = Value(0.0f);
    for (std::size_t i = 0; i < trees.size(); ++i) sum.scaling = sum.scaling + trees[i]->scaling * weights[i];

    // Traverses the union of the trees level by level. A square stores each tree's node index, or no_node.
    using Square = std::array<std::int32_t, 16>;
    std::vector<Square> row, next;
    Square root;
    root.fill(no_node);
    bool varies = false;
    for (std::size_t i = 0; i < trees.size(); ++i)
        if (!trees[i]->nodes.empty()) {
            root[i] = 0;
            varies = true;
        }
    if (varies) row.push_back(root);
    while (!row.empty()) {
        const std::size_t next_first = sum.nodes.size() + row.size();
        next.clear();
        for (const Square& square : row) {
            typename BasicQuadtree<Value>::Node node;
            node.wavelet.fill(Value(0.0f));
            std::uint32_t mask = 0;
            std::array<Square, 4> children;
            for (Square& child : children) child.fill(no_node);
            for (std::size_t i = 0; i < trees.size(); ++i) {
                if (square[i] == no_node) continue;
                const auto& part = trees[i]->nodes[std::size_t(square[i])];
                for (std::size_t a = 0; a < 3; ++a)
                    node.wavelet[a] = node.wavelet[a] + part.wavelet[a] * weights[i];
                for (unsigned q = 0; q < 4; ++q) children[q][i] = child_of(part, q);
                mask |= part.children & 15u;
            }
            if (mask != 0) node.children = static_cast<std::uint32_t>((next_first + next.size()) << 4 | mask);
            for (unsigned q = 0; q < 4; ++q)
                if (mask >> q & 1u) next.push_back(children[q]);
            sum.nodes.push_back(node);
        }
        row.swap(next);
    }
    return sum;
}

template <class Value>
BasicCubemapTree<Value> haar_cubemap(std::span<const Value> texels, int size, const Truncation& truncation) {
    const std::size_t face_texels = std::size_t(size) * std::size_t(size);
    assert(texels.size() == cubemap_faces * face_texels);
    BasicCubemapTree<Value> cubemap;
    for (std::size_t face = 0; face < cubemap_faces; ++face)
        cubemap.faces[face] =
            haar_quadtree(texels.subspan(face * face_texels, face_texels), size, truncation);
    return cubemap;
}

template Quadtree haar_quadtree(std::span<const float>, int, const Truncation&);
template RgbQuadtree haar_quadtree(std::span<const Rgb>, int, const Truncation&);
template std::vector<float> quadtree_texels(const Quadtree&, int);
template std::vector<Rgb> quadtree_texels(const RgbQuadtree&, int);
template Quadtree weighted_sum(std::span<const Quadtree* const>, std::span<const float>);
template RgbQuadtree weighted_sum(std::span<const RgbQuadtree* const>, std::span<const float>);
template CubemapTree haar_cubemap(std::span<const float>, int, const Truncation&);
template RgbCubemapTree haar_cubemap(std::span<const Rgb>, int, const Truncation&);

}  // namespace haarfield
