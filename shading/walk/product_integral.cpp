#include "shading/walk/product_integral.h"

#include <algorithm>
#include <cassert>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shading/walk/product_integral.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "shading/walk/wavelet_blocks-inl.h"

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

struct Light {
    using Value = Rgb;

    const LightPyramid& pyramid;

    bool is_constant(std::size_t face) const { return pyramid.is_constant(face); }
    const Rgb& mean(std::size_t face) const { return pyramid.mean(face); }

    using Ahead = HeadCells<3>::Ahead;

    HWY_INLINE HeadCells<3> operator()(int level, std::size_t face, std::size_t block, Ahead) const {
        const std::size_t index = pyramid.numbers()(level, face, block);
        const LightBlock& light = pyramid.block(index);
        return {{load_cells(light.red.data()), load_cells(light.green.data()), load_cells(light.blue.data())},
                pyramid.varying(index)};
    }
    HWY_INLINE HeadCells<3> last(int level, std::size_t face, std::size_t block, Ahead) const {
        return (*this)(level, face, block, {});
    }
};

/// A constant instead of lighting.
struct One {
    using Value = float;

    bool is_constant(std::size_t) const { return true; }
    float mean(std::size_t) const { return 1; }

    using Ahead = HeadCells<1>::Ahead;

    HWY_INLINE HeadCells<1> operator()(int, std::size_t, std::size_t, Ahead) const {
        return {{all_cells(1)}};
    }
    HWY_INLINE HeadCells<1> last(int, std::size_t, std::size_t, Ahead) const { return {{all_cells(1)}}; }
};

template <int channels, class Head>
typename Head::Value integral(const Head& head, const BlockNumbers& numbers,
                              std::span<const WeightedTrees<float>> factors, int depth,
                              WalkMemory<float>& memory) {
    const Depth levels(depth, numbers.levels());
    ChannelSums<channels> sum;
    Walk<float, Head, ChannelSums<channels>> walk(head, sum, memory, levels);
    typename Head::Value constant_faces(0.0f);
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        const FaceFactors on_face = list_factors(factors, face, memory.varying[0]);
        if (on_face.constant == 0) continue;
        const std::size_t varying = memory.varying[0].factor_count + (head.is_constant(face) ? 0 : 1);
        if (levels.levels > 0 && varying >= sum.needed)
            walk.visit(0, face, 0, on_face.constant * sum.cell_share, {});
        else
            constant_faces += head.mean(face) * on_face.mean;
    }
    return constant_faces + sum.total();
}

Rgb integral_with_light(const LightPyramid& light, std::span<const WeightedTrees<float>> factors, int depth,
                        WalkMemory<float>& memory) {
    return integral<3>(Light{light}, light.numbers(), factors, depth, memory);
}

float integral_only(const BlockNumbers& numbers, std::span<const WeightedTrees<float>> factors, int depth,
                    WalkMemory<float>& memory) {
    return integral<1>(One{}, numbers, factors, depth, memory);
}

template <int channels, class Head>
void write_product(const Head& head, const BlockNumbers& numbers,
                   std::span<const WeightedTrees<float>> factors, int depth, WalkMemory<float>& memory,
                   std::vector<WaveletBlock<channels>>& blocks) {
    const Depth levels(depth, numbers.levels());
    BlockWriter<channels> writer{numbers, blocks};
    Walk<float, Head, BlockWriter<channels>> walk(head, writer, memory, levels);
    blocks.clear();
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        const FaceFactors on_face = list_factors(factors, face, memory.varying[0]);
        const bool varies = memory.varying[0].factor_count > 0 || !head.is_constant(face);
        if (levels.levels > 0 && varies && on_face.constant != 0) {
            walk.visit(0, face, 0, on_face.constant, {});
            continue;
        }
        const auto place = static_cast<std::uint32_t>(blocks.size());
        WaveletBlock<channels>& root = blocks.emplace_back();
        root.block = static_cast<std::uint32_t>(face);
        root.parent = place;
        root.cell = root.level = 0;
        const auto mean = head.mean(face) * on_face.mean;
        for (int c = 0; c < channels; ++c) {
            root.amplitude[std::size_t(c)].fill(0);
            if constexpr (channels == 1)
                root.amplitude[0][0] = mean;
            else
                root.amplitude[std::size_t(c)][0] = mean[c];
        }
    }
}

void product_with_light(const LightPyramid& light, std::span<const WeightedTrees<float>> factors, int depth,
                        WalkMemory<float>& memory, std::vector<WaveletBlock<3>>& blocks) {
    write_product(Light{light}, light.numbers(), factors, depth, memory, blocks);
}

void product_only(const BlockNumbers& numbers, std::span<const WeightedTrees<float>> factors, int depth,
                  WalkMemory<float>& memory, std::vector<WaveletBlock<1>>& blocks) {
    write_product(One{}, numbers, factors, depth, memory, blocks);
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haarfield {

namespace {

/// Number of points whose trees fit a core's L2 cache.
constexpr std::size_t points_at_once = 8;

/// Prefetches trees into the L2 cache by reading them sequentially. Memory is several times as fast for
/// sequential reads as for prefetches of single nodes.
void prefetch_trees(std::span<const WeightedTrees<float>> factors) {
    constexpr std::size_t line = 64;
    unsigned sum = 0;
    for (const WeightedTrees<float>& factor : factors)
        for (const auto& part : factor.parts)
            for (const WideFace<float>& face : *part.tree) {
                const auto* bytes = reinterpret_cast<const unsigned char*>(face.root);
                for (std::size_t at = 0; at < face.nodes * sizeof(WideNode<float>); at += line)
                    sum += bytes[at];
            }
    volatile unsigned wanted = sum;
    static_cast<void>(wanted);
}

}  // namespace

HWY_EXPORT(integral_with_light);
HWY_EXPORT(integral_only);
HWY_EXPORT(product_with_light);
HWY_EXPORT(product_only);

float product_integral(int face_size, std::span<const WeightedTrees<float>> factors, int depth,
                       WalkMemory<float>& memory) {
    memory.reserve(factors);
    return HWY_DYNAMIC_DISPATCH(integral_only)(BlockNumbers(face_size), factors, depth, memory);
}

Rgb product_integral(const LightPyramid& light, std::span<const WeightedTrees<float>> factors, int depth,
                     WalkMemory<float>& memory) {
    memory.reserve(factors);
    return HWY_DYNAMIC_DISPATCH(integral_with_light)(light, factors, depth, memory);
}

void product_integrals(const LightPyramid& light,
                       std::span<const std::span<const WeightedTrees<float>>> factors, int depth,
                       WalkMemory<float>& memory, std::span<Rgb> integrals) {
    assert(integrals.size() == factors.size());
    const auto function = HWY_DYNAMIC_DISPATCH(integral_with_light);
    for (std::size_t first = 0; first < factors.size(); first += points_at_once) {
        const std::size_t end = std::min(first + points_at_once, factors.size());
        for (std::size_t i = first; i < end; ++i) prefetch_trees(factors[i]);
        for (std::size_t i = first; i < end; ++i) {
            memory.reserve(factors[i]);
            integrals[i] = function(light, factors[i], depth, memory);
        }
    }
}

void function_product(const LightPyramid& light, std::span<const WeightedTrees<float>> factors, int depth,
                      WalkMemory<float>& memory, std::vector<WaveletBlock<3>>& product) {
    memory.reserve(factors);
    HWY_DYNAMIC_DISPATCH(product_with_light)(light, factors, depth, memory, product);
}

void function_product(int face_size, std::span<const WeightedTrees<float>> factors, int depth,
                      WalkMemory<float>& memory, std::vector<WaveletBlock<1>>& product) {
    memory.reserve(factors);
    HWY_DYNAMIC_DISPATCH(product_only)(BlockNumbers(face_size), factors, depth, memory, product);
}

}  // namespace haarfield
#endif
