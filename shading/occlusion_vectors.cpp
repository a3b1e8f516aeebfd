#include "shading/occlusion_vectors.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>

#include "shading/coefficient_energies.h"
#include "shading/square_transform.h"

namespace haarfield {
namespace {

/// Makes one vector after another.
class OcclusionMaker {
public:
    OcclusionMaker(int face_size, double error)
        : numbers_(face_size), error_(error), values_(numbers_.count()) {
        for (int level = 0; level < numbers_.levels(); ++level)
            for (std::size_t slot = 0; slot < wide_cells; ++slot)
                normalisation_[std::size_t(level)][slot] = coefficient_of_amplitude(level, slot);
    }

    void append(const WideCubemap<std::uint8_t>& visibility, SparseVectors& to) {
        energies_.clear(numbers_.count());
        for (std::size_t face = 0; face < cubemap_faces; ++face) {
            SlotValues constant{};
            constant[0] = 1 - (visibility[face].root ? 1.0f : visibility[face].mean);
            if (visibility[face].root)
                add_square(*visibility[face].root, 0, face, 0);
            else if (constant[0] != 0)
                add_block(numbers_(0, face, 0), constant);
        }
        const std::size_t count = energies_.mark(error_ * error_ * energies_.sum);
        index_.clear();
        value_.clear();
        index_.reserve(count);
        for (std::size_t i = 0; i < energies_.blocks; ++i)
            for (unsigned left = energies_.marks[i]; left != 0; left &= left - 1) {
                const auto slot = static_cast<std::uint32_t>(std::countr_zero(left));
                index_.push_back(energies_.place[i] * static_cast<std::uint32_t>(wide_cells) + slot);
                value_.push_back(values_[i][slot]);
            }
        to.append(index_, value_);
    }

private:
    /// Adds the coefficients of a square and of what lies below, and returns its mean.
    float add_square(const WideNode<std::uint8_t>& node, int level, std::size_t face, std::size_t block) {
        SlotValues cell;
        const WideNode<std::uint8_t>* child = &node + node.first_child;
        for (unsigned k = 0; k < wide_cells; ++k)
            cell[k] = node.varying >> k & 1u ? add_square(*child++, level + 1, face, block * wide_cells + k)
                                             : 1 - static_cast<float>(node.mean[k]) * cell_unit<std::uint8_t>;
        const float mean = transform_cells(cell.data());
        for (std::size_t slot = 0; slot < wide_cells; ++slot)
            cell[slot] *= normalisation_[std::size_t(level)][slot];
        add_block(numbers_(level, face, block), cell);
        return mean;
    }

    void add_block(std::size_t block, const SlotValues& coefficients) {
        const std::size_t place = energies_.blocks++;
        values_[place] = coefficients;
        energies_.place[place] = static_cast<std::uint32_t>(block);
        float sum = 0;
        for (std::size_t slot = 0; slot < wide_cells; ++slot)
            sum += energies_.energy[place][slot] = coefficients[slot] * coefficients[slot];
        energies_.sum += double(sum);
    }

    BlockNumbers numbers_;
    double error_;
    std::array<SlotValues, 4> normalisation_{};  ///< By level: coefficient_of_amplitude.
    CoefficientEnergies energies_;
    std::vector<SlotValues> values_;  ///< By place in energies_.
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
    if (progress.stop.stop_requested()) return Error{"", interrupted};
    return occlusions;
}

}  // namespace haarfield
