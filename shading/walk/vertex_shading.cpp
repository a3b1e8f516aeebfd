#include "shading/walk/vertex_shading.h"

#include <hwy/cache_control.h>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shading/walk/vertex_shading.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "shading/walk/face_shading-inl.h"
#include "shading/walk/wavelet_blocks-inl.h"

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

struct RadianceSum : ChannelSums<3> {
    static constexpr bool may_prune = true;

    float negligible, error = 0;  ///< See Walk.

    explicit RadianceSum(float negligible_error) : negligible(negligible_error) {}
    bool needs_bounds() const { return negligible > 0; }
};

/// Prefetches what list_factors reads.
void prefetch_faces(std::span<const WeightedTrees<std::uint8_t>> factors) {
    for (const WeightedTrees<std::uint8_t>& factor : factors)
        for (const auto& part : factor.parts) {
            hwy::Prefetch(part.tree);
            hwy::Prefetch(&part.tree->back());
        }
}

/// Prefetches the nodes that are listed.
void prefetch_nodes(const VaryingFactors<std::uint8_t>& varying) {
    for (std::size_t i = 0; i < varying.node_count; ++i) hwy::Prefetch(varying.nodes[i].node);
}

/// Walks the faces that are lit, into a sink. The factors of the next one are listed before, and their
/// nodes prefetched.
template <class Reflected, class Sink>
void walk_faces(const Reflected& reflected, const PreparedVertex& vertex, const Depth& depth,
                WalkMemory<std::uint8_t>& memory, Sink& sink) {
    std::size_t next = 0;
    FaceFactors of_next;
    const auto list_next = [&](std::size_t face) {
        while (face < cubemap_faces && FaceShading<Reflected>::is_dark(vertex.brdf.normal, face)) ++face;
        next = face;
        if (face == cubemap_faces) return;
        of_next = list_factors(vertex.sight.trees, face, memory.next);
        prefetch_nodes(memory.next);
    };
    list_next(0);
    while (next < cubemap_faces) {
        const std::size_t face = next;
        const float constant = of_next.constant;
        std::swap(memory.varying[0], memory.next);
        list_next(face + 1);
        if (constant == 0) continue;
        const FaceShading shading(reflected, vertex, face, memory.sides);
        Walk<std::uint8_t, FaceShading<Reflected>, Sink> walk(shading, sink, memory, depth);
        walk.visit(0, face, 0, constant * Sink::cell_share, shading.root());
    }
}

RadianceSum walked(const LightPyramid& light, const PreparedVertex& vertex, const Depth& depth,
                   float negligible, WalkMemory<std::uint8_t>& memory) {
    RadianceSum sum(negligible);
    walk_faces(LitColours{light}, vertex, depth, memory, sum);
    return sum;
}

float size_of(const Rgb& radiance) {
    return std::abs(radiance.x) + std::abs(radiance.y) + std::abs(radiance.z);
}

Rgb radiance(const LightPyramid& light, const ShadedVertex& vertex, float tolerance,
             WalkMemory<std::uint8_t>& memory) {
    const int face_levels = light.numbers().levels();
    const Depth levels(vertex.depth, face_levels);
    prefetch_faces(vertex.sight.trees);
    const PreparedVertex prepared(vertex, levels.levels - 1);
    if (tolerance > 0 && levels.levels > 1) {
        // Of a coarse guess at the radiance, each of some hundred cells may spoil its share; the sum of the
        // bounds is checked against what is found, and where it is too much the cells may spoil less.
        const PreparedVertex coarse(vertex, 0);
        const Rgb guess = walked(light, coarse, Depth(2, face_levels), 0, memory).total();
        float negligible = tolerance * size_of(guess) / 128;
        for (int trial = 0; trial < 3 && negligible > 0; ++trial, negligible /= 8) {
            const RadianceSum sum = walked(light, prepared, levels, negligible, memory);
            const Rgb total = sum.total();
            // The full walk's result is at least this less the error, so this is enough:
            if (sum.error <= tolerance * (size_of(total) - sum.error)) return total;
        }
    }
    return walked(light, prepared, levels, 0, memory).total();
}

/// Writes the highlights, and adds up what is reflected diffusely.
struct HighlightWriter : BlockWriter<3, true> {
    using Leaves = LeavesOf<HighlightWriter>;

    Cells diffuse[3];

    HighlightWriter(const BlockNumbers& of_blocks, std::vector<WaveletBlock<3>>& to,
                    const DetailWeights* details)
        : BlockWriter{of_blocks, to, details} {
        for (Cells& channel : diffuse) channel = all_cells(0);
    }
    Rgb total() const { return Rgb(sum_of(diffuse[0]), sum_of(diffuse[1]), sum_of(diffuse[2])); }
    HWY_INLINE void add(int level, std::size_t face, std::size_t block, unsigned done, const Cells& product,
                        const LitHighlights::Values& head) {
        add_diffuse(level, done, product, head);
        BlockWriter::add(level, face, block, done, product, head);
    }
    HWY_INLINE void open(int level, std::size_t face, std::size_t block, unsigned done, const Cells& product,
                         const LitHighlights::Values& head) {
        add_diffuse(level, done, product, head);
        BlockWriter::open(level, face, block, done, product, head);
    }

private:
    HWY_INLINE void add_diffuse(int level, unsigned done, const Cells& product,
                                const LitHighlights::Values& head) {
        static constexpr float cell_of_level[] = {0x1p-4f, 0x1p-8f, 0x1p-12f, 0x1p-16f};
        const Cells share = only(done, product) * all_cells(cell_of_level[level]);
        for (int c = 0; c < 3; ++c) diffuse[c] = multiply_add(share, head.diffuse[c], diffuse[c]);
    }
};

/// Writes what is reflected, times what is seen.
template <class Writer, class Reflected>
void write_product(const Reflected& reflected, const ShadedVertex& vertex, WalkMemory<std::uint8_t>& memory,
                   Writer& writer) {
    const Depth levels(vertex.depth, writer.numbers.levels());
    prefetch_faces(vertex.sight.trees);
    const PreparedVertex prepared(vertex, levels.levels - 1, lobe_of_terms_varies);
    writer.blocks.clear();
    walk_faces(reflected, prepared, levels, memory, writer);
}

double integrand(const LightPyramid& light, const ShadedVertex& vertex, const DetailWeights* detail,
                 WalkMemory<std::uint8_t>& memory, std::vector<WaveletBlock<3>>& product) {
    BlockWriter<3, true> writer{light.numbers(), product, detail};
    write_product(LitColours{light}, vertex, memory, writer);
    return writer.blurred_energy;
}

HighlightIntegrand highlights(const LightPyramid& light, const ShadedVertex& vertex,
                              const DetailWeights* detail, WalkMemory<std::uint8_t>& memory,
                              std::vector<WaveletBlock<3>>& product) {
    VertexBrdf brdf = vertex.brdf;
    brdf.diffuse = Rgb(0.0f);
    HighlightWriter writer(light.numbers(), product, detail);
    write_product(LitHighlights{{light}, vertex.brdf.diffuse},
                  {vertex.directions, brdf, vertex.sight, vertex.depth}, memory, writer);
    return {writer.total(), writer.blurred_energy};
}

template <int count>
void write_terms(const BlockNumbers& numbers, const ShadedVertex& vertex, WalkMemory<std::uint8_t>& memory,
                 std::vector<WaveletBlock<count>>& product) {
    BlockWriter<count> writer{numbers, product};
    write_product(PlainTerms<count>(), vertex, memory, writer);
}

void two_terms(const BlockNumbers& numbers, const ShadedVertex& vertex, WalkMemory<std::uint8_t>& memory,
               std::vector<WaveletBlock<2>>& product) {
    write_terms(numbers, vertex, memory, product);
}

void three_terms(const BlockNumbers& numbers, const ShadedVertex& vertex, WalkMemory<std::uint8_t>& memory,
                 std::vector<WaveletBlock<3>>& product) {
    write_terms(numbers, vertex, memory, product);
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haarfield {

HWY_EXPORT(radiance);
HWY_EXPORT(integrand);
HWY_EXPORT(highlights);
HWY_EXPORT(two_terms);
HWY_EXPORT(three_terms);

Rgb outgoing_radiance(const LightPyramid& light, const ShadedVertex& vertex, WalkMemory<std::uint8_t>& memory,
                      float tolerance) {
    memory.reserve(vertex.sight.trees);
    return HWY_DYNAMIC_DISPATCH(radiance)(light, vertex, tolerance, memory);
}

double radiance_integrand(const LightPyramid& light, const ShadedVertex& vertex,
                          WalkMemory<std::uint8_t>& memory, std::vector<WaveletBlock<3>>& product,
                          const DetailWeights* detail) {
    memory.reserve(vertex.sight.trees);
    return HWY_DYNAMIC_DISPATCH(integrand)(light, vertex, detail, memory, product);
}

HighlightIntegrand highlight_integrand(const LightPyramid& light, const ShadedVertex& vertex,
                                       WalkMemory<std::uint8_t>& memory,
                                       std::vector<WaveletBlock<3>>& product, const DetailWeights* detail) {
    memory.reserve(vertex.sight.trees);
    return HWY_DYNAMIC_DISPATCH(highlights)(light, vertex, detail, memory, product);
}

void transfer_terms(const BlockNumbers& numbers, const ShadedVertex& vertex, WalkMemory<std::uint8_t>& memory,
                    std::vector<WaveletBlock<2>>& product) {
    memory.reserve(vertex.sight.trees);
    HWY_DYNAMIC_DISPATCH(two_terms)(numbers, vertex, memory, product);
}

void transfer_terms(const BlockNumbers& numbers, const ShadedVertex& vertex, WalkMemory<std::uint8_t>& memory,
                    std::vector<WaveletBlock<3>>& product) {
    memory.reserve(vertex.sight.trees);
    HWY_DYNAMIC_DISPATCH(three_terms)(numbers, vertex, memory, product);
}

}  // namespace haarfield
#endif
