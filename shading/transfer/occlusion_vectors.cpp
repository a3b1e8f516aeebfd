#include "shading/transfer/occlusion_vectors.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>

#include "shading/transfer/coefficient_energies.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shading/transfer/occlusion_vectors.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "shading/walk/wavelet_blocks-inl.h"

#ifndef HAARFIELD_OCCLUSION_VECTORS_ONCE
#define HAARFIELD_OCCLUSION_VECTORS_ONCE

namespace haarfield {

/// The coefficients of one function, by block.
struct OcclusionBlocks {
    BlockNumbers numbers;
    EnergyWeights weights{all_alike()};
    CoefficientEnergies energies;
    std::vector<SlotValues> values;  ///< By place in `energies`.

    explicit OcclusionBlocks(int face_size) : numbers(face_size), values(numbers.count()) {}

private:
    static CoefficientSpectrum all_alike() {
        CoefficientSpectrum spectrum;
        spectrum.fill(1);
        return spectrum;
    }
};

}  // namespace haarfield

#endif

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

/// Adds the occlusion of a square and its descendants. Returns the mean of the square.
float add_square(OcclusionBlocks& blocks, const WideNode<std::uint8_t>& node, int level, std::size_t face,
                 std::size_t block) {
    const WideNode<std::uint8_t>* child = &node + node.first_child;
    Cells hidden = all_cells(1) - load_cells(node.mean.data()) * all_cells(cell_unit<std::uint8_t>);
    if (node.varying != 0) {
        alignas(64) float cells[wide_cells];
        store_cells(hidden, cells);
        for_each_bit(node.varying, [&](unsigned cell) {
            cells[cell] = add_square(blocks, *child++, level + 1, face, block * wide_cells + cell);
        });
        hidden = load_cells(cells);
    }
    const Cells slots = transformed(hidden),
                coefficients = slots * load_cells(blocks.weights.normalisation[std::size_t(level)].data()),
                energies = coefficients * coefficients;
    const std::size_t place = blocks.energies.blocks++;
    store_cells(coefficients, blocks.values[place].data());
    store_cells(energies, blocks.energies.energy[place].data());
    blocks.energies.place[place] = static_cast<std::uint32_t>(blocks.numbers(level, face, block));
    blocks.energies.sum += double(sum_of(energies));
    return first_cell(slots);
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haarfield {

HWY_EXPORT(add_square);

namespace {

/// Makes one vector at a time.
class OcclusionMaker {
public:
    OcclusionMaker(int face_size, double error) : blocks_(face_size), error_(error) {}

    void append(const WideCubemap<std::uint8_t>& visibility, SparseVectors& to) {
        CoefficientEnergies& energies = blocks_.energies;
        energies.clear(blocks_.numbers.count());
        for (std::size_t face = 0; face < cubemap_faces; ++face)
            if (visibility[face].root)
                HWY_DYNAMIC_DISPATCH(add_square)(blocks_, *visibility[face].root, 0, face, 0);
            else if (visibility[face].mean != 1)
                add_constant(face, 1 - visibility[face].mean);
        const std::size_t count = energies.mark(error_ * error_ * energies.sum);
        index_.clear();
        value_.clear();
        index_.reserve(count);
        for (std::size_t i = 0; i < energies.blocks; ++i)
            for (unsigned left = energies.marks[i]; left != 0; left &= left - 1) {
                const auto slot = static_cast<std::uint32_t>(std::countr_zero(left));
                index_.push_back(energies.place[i] * static_cast<std::uint32_t>(wide_cells) + slot);
                value_.push_back(blocks_.values[i][slot]);
            }
        to.append(index_, value_);
    }

private:
    void add_constant(std::size_t face, float hidden) {
        CoefficientEnergies& energies = blocks_.energies;
        const std::size_t place = energies.blocks++;
        blocks_.values[place] = {hidden};
        energies.energy[place] = {hidden * hidden};
        energies.place[place] = static_cast<std::uint32_t>(blocks_.numbers(0, face, 0));
        energies.sum += double(hidden) * double(hidden);
    }

    OcclusionBlocks blocks_;
    double error_;
    std::vector<std::uint32_t> index_;
    std::vector<float> value_;
};

}  // namespace

Result<SparseVectorBlocks> occlusion_vectors(const VisibilityField& field, const WideVisibility& visibility,
                                             double error, const Progress& progress) {
    const std::size_t planar = field.planar_handles.size();
    SparseVectorBlocks occlusions(planar + field.spherical_handles.size(), field.pool.face_size, 1);
    tbb::enumerable_thread_specific<OcclusionMaker> makers(
        [&] { return OcclusionMaker(field.pool.face_size, error); });
    tbb::parallel_for(std::size_t(0), occlusions.blocks.size(), [&](std::size_t b) {
        OcclusionMaker& maker = makers.local();
        const std::size_t end = std::min(occlusions.rows, (b + 1) * SparseVectorBlocks::block_rows);
        for (std::size_t i = b * SparseVectorBlocks::block_rows; i < end; ++i) {
            if (progress.stop.stop_requested()) return;
            const auto sample = static_cast<std::uint32_t>(i < planar ? i : i - planar);
            maker.append(i < planar ? visibility.planar(sample) : visibility.spherical(sample),
                         occlusions.blocks[b]);
        }
    });
    if (progress.stop.stop_requested()) return interruption();
    return occlusions;
}

}  // namespace haarfield
#endif
