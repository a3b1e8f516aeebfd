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

/// Sums the diffuse component next to the channels, over all cells.
struct OutgoingSum : ChannelSums<3> {
    Cells diffuse[3];

    OutgoingSum() {
        for (Cells& channel : diffuse) channel = all_cells(0);
    }
    Outgoing total() const {
        return {Rgb(sum_of(diffuse[0]), sum_of(diffuse[1]), sum_of(diffuse[2])), ChannelSums::total()};
    }
    HWY_INLINE void add(int, std::size_t, std::size_t, unsigned done, const Cells& product,
                        const SeparateColours& head) {
        add_block(only(done, product), head, *this);
    }
    HWY_INLINE void open(int level, std::size_t face, std::size_t block, unsigned done, const Cells& product,
                         const SeparateColours& head) {
        add(level, face, block, done, product, head);
    }

    /// With its own sums, which stay in registers.
    struct Leaves {
        OutgoingSum& whole;
        Cells sum[3], diffuse[3];

        HWY_INLINE explicit Leaves(OutgoingSum& to) : whole(to) {
            for (int c = 0; c < 3; ++c) sum[c] = diffuse[c] = all_cells(0);
        }
        HWY_INLINE ~Leaves() {
            for (int c = 0; c < 3; ++c) {
                whole.sum[c] = whole.sum[c] + sum[c];
                whole.diffuse[c] = whole.diffuse[c] + diffuse[c];
            }
        }
        HWY_INLINE void add(int, std::size_t, std::size_t, const Cells& product,
                            const SeparateColours& head) {
            add_block(product, head, *this);
        }
    };

private:
    template <class Sums>
    static HWY_INLINE void add_block(const Cells& product, const SeparateColours& head, Sums& to) {
        for (int c = 0; c < 3; ++c) to.diffuse[c] = multiply_add(product, head.diffuse[c], to.diffuse[c]);
        if (head.used > 0)
            for (int c = 0; c < 3; ++c) to.sum[c] = multiply_add(product, head.value[c], to.sum[c]);
    }
};

/// Prefetches the data that list_factors reads.
void prefetch_faces(std::span<const WeightedTrees<std::uint8_t>> factors) {
    for (const WeightedTrees<std::uint8_t>& factor : factors)
        for (const auto& part : factor.parts) {
            hwy::Prefetch(part.tree);
            hwy::Prefetch(&part.tree->back());
        }
}

/// Prefetches the listed nodes.
void prefetch_nodes(const VaryingFactors<std::uint8_t>& varying) {
    for (std::size_t i = 0; i < varying.node_count; ++i) hwy::Prefetch(varying.nodes[i].node);
}

/// Walks the lit faces. Lists the factors of the next face and prefetches their nodes before the current face
/// is walked.
template <class Reflected, class Sink>
void walk_faces(const Reflected& reflected, const PreparedVertex& vertex, const Depth& depth,
                WalkMemory<std::uint8_t>& memory, Sink& sink) {
    std::size_t next = 0;
    FaceFactors of_next;
    const auto list_next = [&](std::size_t face) {
        while (face < cubemap_faces && FaceShading<Reflected>::is_dark(vertex.brdf.normal, face)) ++face;
        next = face;
        if (face == cubemap_faces) return;
        of_next = list_factors(vertex.visibility.trees, face, memory.next);
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

Outgoing radiance(const LightPyramid& light, const ShadedVertex& vertex, WalkMemory<std::uint8_t>& memory) {
    const Depth levels(vertex.depth, light.numbers().levels());
    prefetch_faces(vertex.visibility.trees);
    const PreparedVertex prepared(vertex, levels.levels - 1);
    if (vertex.brdf.specular == Rgb(0.0f)) {
        ChannelSums<3> sum;
        walk_faces(LitColours<false>{light}, prepared, levels, memory, sum);
        return {sum.total(), Rgb(0.0f)};
    }
    OutgoingSum sum;
    walk_faces(LitColours<true>{light}, prepared, levels, memory, sum);
    return sum.total();
}

/// Writes the product of the specular component, and sums the diffuse component.
struct SpecularWriter : BlockWriter<3, true> {
    using Leaves = LeavesOf<SpecularWriter>;

    Cells diffuse[3];

    SpecularWriter(const BlockNumbers& of_blocks, std::vector<WaveletBlock<3>>& to,
                   const DetailWeights* details)
        : BlockWriter{of_blocks, to, details} {
        for (Cells& channel : diffuse) channel = all_cells(0);
    }
    Rgb total() const { return Rgb(sum_of(diffuse[0]), sum_of(diffuse[1]), sum_of(diffuse[2])); }
    HWY_INLINE void add(int level, std::size_t face, std::size_t block, unsigned done, const Cells& product,
                        const SeparateColours& head) {
        add_diffuse(level, done, product, head);
        BlockWriter::add(level, face, block, done, product, head);
    }
    HWY_INLINE void open(int level, std::size_t face, std::size_t block, unsigned done, const Cells& product,
                         const SeparateColours& head) {
        add_diffuse(level, done, product, head);
        BlockWriter::open(level, face, block, done, product, head);
    }

private:
    HWY_INLINE void add_diffuse(int level, unsigned done, const Cells& product, const SeparateColours& head) {
        static constexpr float cell_of_level[] = {0x1p-4f, 0x1p-8f, 0x1p-12f, 0x1p-16f};
        const Cells share = only(done, product) * all_cells(cell_of_level[level]);
        for (int c = 0; c < 3; ++c) diffuse[c] = multiply_add(share, head.diffuse[c], diffuse[c]);
    }
};

/// Writes the product of light or terms, BRDF and visibilities.
template <class Writer, class Reflected>
void write_product(const Reflected& reflected, const ShadedVertex& vertex, WalkMemory<std::uint8_t>& memory,
                   Writer& writer) {
    const Depth levels(vertex.depth, writer.numbers.levels());
    prefetch_faces(vertex.visibility.trees);
    const PreparedVertex prepared(vertex, levels.levels - 1, lobe_of_terms_varies);
    writer.blocks.clear();
    walk_faces(reflected, prepared, levels, memory, writer);
}

double integrand(const LightPyramid& light, const ShadedVertex& vertex, const DetailWeights* detail,
                 WalkMemory<std::uint8_t>& memory, std::vector<WaveletBlock<3>>& product) {
    BlockWriter<3, true> writer{light.numbers(), product, detail};
    write_product(LitColours<false>{light}, vertex, memory, writer);
    return writer.blurred_energy;
}

SpecularIntegrand specular_lobes(const LightPyramid& light, const ShadedVertex& vertex,
                                 const DetailWeights* detail, WalkMemory<std::uint8_t>& memory,
                                 std::vector<WaveletBlock<3>>& product) {
    SpecularWriter writer(light.numbers(), product, detail);
    write_product(LitColours<true>{light}, vertex, memory, writer);
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
HWY_EXPORT(specular_lobes);
HWY_EXPORT(two_terms);
HWY_EXPORT(three_terms);

Outgoing outgoing_radiance(const LightPyramid& light, const ShadedVertex& vertex,
                           WalkMemory<std::uint8_t>& memory) {
    memory.reserve(vertex.visibility.trees);
    return HWY_DYNAMIC_DISPATCH(radiance)(light, vertex, memory);
}

double radiance_integrand(const LightPyramid& light, const ShadedVertex& vertex,
                          WalkMemory<std::uint8_t>& memory, std::vector<WaveletBlock<3>>& product,
                          const DetailWeights* detail) {
    memory.reserve(vertex.visibility.trees);
    return HWY_DYNAMIC_DISPATCH(integrand)(light, vertex, detail, memory, product);
}

SpecularIntegrand specular_integrand(const LightPyramid& light, const ShadedVertex& vertex,
                                     WalkMemory<std::uint8_t>& memory, std::vector<WaveletBlock<3>>& product,
                                     const DetailWeights* detail) {
    memory.reserve(vertex.visibility.trees);
    return HWY_DYNAMIC_DISPATCH(specular_lobes)(light, vertex, detail, memory, product);
}

void transfer_terms(const BlockNumbers& numbers, const ShadedVertex& vertex, WalkMemory<std::uint8_t>& memory,
                    std::vector<WaveletBlock<2>>& product) {
    memory.reserve(vertex.visibility.trees);
    HWY_DYNAMIC_DISPATCH(two_terms)(numbers, vertex, memory, product);
}

void transfer_terms(const BlockNumbers& numbers, const ShadedVertex& vertex, WalkMemory<std::uint8_t>& memory,
                    std::vector<WaveletBlock<3>>& product) {
    memory.reserve(vertex.visibility.trees);
    HWY_DYNAMIC_DISPATCH(three_terms)(numbers, vertex, memory, product);
}

}  // namespace haarfield
#endif
