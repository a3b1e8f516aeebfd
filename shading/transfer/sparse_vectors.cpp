#include "shading/transfer/sparse_vectors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

#include "fields/wavelets/largest_by_energy.h"

namespace haarfield {

float coefficient_of_amplitude(int block_level, std::size_t slot) {
    if (slot == 0) return block_level == 0 ? 1 : 0;
    return std::ldexp(1.0f, 1 - static_cast<int>(spectrum_place(block_level, slot)));
}

double coefficients_at(std::size_t place) {
    return cubemap_faces * (place == 0 ? 1 : std::ldexp(3.0, 2 * (static_cast<int>(place) - 1)));
}

std::size_t spectrum_place(const BlockNumbers& numbers, std::uint32_t index) {
    return spectrum_place(level_of_block(numbers, index / wide_cells), index % wide_cells);
}

int level_of_block(const BlockNumbers& numbers, std::size_t block) {
    int level = 0;
    while (level + 1 < numbers.levels() && block >= numbers(level + 1, 0, 0)) ++level;
    return level;
}

CoefficientSum::CoefficientSum(int face_size)
    : face_size_(face_size),
      numbers_(face_size),
      values_(coefficient_count(face_size), 0.0f),
      is_known_(coefficient_count(face_size), 0) {
    assert(face_size >= 2);
}

void CoefficientSum::clear() {
    for (const std::uint32_t index : indices_) {
        values_[index] = 0;
        is_known_[index] = 0;
    }
    indices_.clear();
}

void CoefficientSum::add(std::uint32_t index, float value) {
    if (value == 0) return;
    if (!is_known_[index]) {
        is_known_[index] = 1;
        indices_.push_back(index);
    }
    values_[index] += value;
}

void CoefficientSum::add(const CubemapTree& f, float weight) {
    const auto index_of = [this](int block_level, std::size_t face, std::size_t block) {
        return static_cast<std::uint32_t>(numbers_(block_level, face, block) * wide_cells);
    };
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        const Quadtree& tree = f.faces[face];
        add(index_of(0, face, 0), weight * tree.scaling);
        squares_.resize(tree.nodes.size());
        if (!squares_.empty()) squares_[0] = 1;
        for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
            const Quadtree::Node& node = tree.nodes[i];
            const std::uint32_t square = squares_[i];
            const int level = (std::bit_width(square) - 1) / 2;
            const float factor = weight * std::ldexp(1.0f, -level);
            const std::uint32_t in_level = square - (1u << (2 * level));
            // On odd levels the square is a quadrant of its block.
            const bool is_quadrant = level % 2 == 1;
            const std::uint32_t first = index_of(level / 2, face, is_quadrant ? in_level >> 2 : in_level) +
                                        (is_quadrant ? 4 * (in_level & 3u) + 1 : 4),
                                step = is_quadrant ? 1 : 4;
            for (std::uint32_t kind = 0; kind < 3; ++kind)
                add(first + step * kind, factor * node.wavelet[kind]);
            for (unsigned quadrant = 0; quadrant < 4; ++quadrant)
                if (const std::int32_t child = child_of(node, quadrant); child != no_node)
                    squares_[std::size_t(child)] = 4 * square + quadrant;
        }
    }
}

namespace {

/// Returns the nearest half float (ties to even) for a magnitude of at most slightly more than 1. Without
/// branches: Imath's conversion takes several times as long.
std::uint16_t half_bits(float value) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    const std::uint32_t magnitude = bits & 0x7fffffffu;
    // The exponent bias is 15 instead of 127, and the mantissa has 13 bits less.
    const std::uint32_t normal = (magnitude - (112u << 23) + 0xfffu + (magnitude >> 13 & 1u)) >> 13;
    // Below 2^-14 the value is a multiple of 2^-24, to which adding 1/2 rounds.
    const std::uint32_t small =
        std::bit_cast<std::uint32_t>(std::bit_cast<float>(magnitude) + 0.5f) - (126u << 23);
    return static_cast<std::uint16_t>((bits >> 16 & 0x8000u) | (magnitude < 113u << 23 ? small : normal));
}

}  // namespace

std::vector<std::uint32_t> largest_energies(std::span<const double> energies, float error) {
    std::vector<std::uint32_t> places(energies.size());
    std::iota(places.begin(), places.end(), 0u);
    const auto matters_more = [&](std::uint32_t a, std::uint32_t b) {
        return std::pair(energies[a], a) > std::pair(energies[b], b);
    };
    if (error > 0)
        places.resize(largest_by_energy(
            std::span(places), std::accumulate(energies.begin(), energies.end(), 0.0) * squared(error),
            [&](std::uint32_t place) { return energies[place]; }, matters_more));
    std::ranges::sort(places, matters_more);
    return places;
}

CoefficientSpectrum root_mean_squares(const SpectrumEnergies& sums, double functions) {
    CoefficientSpectrum spectrum;
    for (std::size_t place = 0; place < spectrum.size(); ++place) {
        spectrum[place] = static_cast<float>(std::sqrt(sums[place] / (functions * coefficients_at(place))));
    }
    return spectrum;
}

std::size_t SparseVectors::bytes() const {
    return first.size() * sizeof first[0] + (index.size() + value.size()) * sizeof index[0] +
           scale.size() * sizeof scale[0];
}

void SparseVectors::append(std::span<const std::uint32_t> indices, std::span<const float> values) {
    const auto stride = static_cast<std::size_t>(channels);
    assert(values.size() == stride * indices.size());
    float largest = 0;
    for (const float v : values) largest = std::max(largest, std::abs(v));
    const float factor = largest > 0 ? 1 / largest : 0;
    const std::size_t before = index.size(), page_count = pages(), count = largest > 0 ? indices.size() : 0;
    index.resize(before + count);
    value.resize(stride * (before + count));
    std::uint16_t *next_index = index.data() + before, *next_value = value.data() + stride * before;
    for (std::size_t page = 0; page < page_count; ++page) {
        for (std::size_t i = 0; i < count; ++i) {
            if (indices[i] >> 16 != page) continue;
            *next_index++ = static_cast<std::uint16_t>(indices[i]);
            for (std::size_t c = 0; c < stride; ++c)
                *next_value++ = half_bits(values[stride * i + c] * factor);
        }
        first.push_back(static_cast<std::uint32_t>(next_index - index.data()));
    }
    scale.push_back(largest);
}

void SparseVectors::append(const CoefficientSum& f) {
    std::vector<float> values;
    for (const std::uint32_t i : f.indices()) values.push_back(f[i]);
    append(f.indices(), values);
}

void SparseVectors::clear() {
    first.resize(1);
    index.clear();
    value.clear();
    scale.clear();
}

SparseVectorBlocks::SparseVectorBlocks(std::size_t row_count, int face_size, int channels)
    : rows(row_count),
      blocks((row_count + block_rows - 1) / block_rows, SparseVectors(face_size, channels)) {}

std::size_t SparseVectorBlocks::bytes() const {
    std::size_t sum = 0;
    for (const SparseVectors& block : blocks) sum += block.bytes();
    return sum;
}

std::size_t SparseVectorBlocks::coefficients() const {
    std::size_t sum = 0;
    for (const SparseVectors& block : blocks) sum += block.index.size();
    return sum;
}

DenseCoefficients dense_coefficients(const RgbCubemapTree& f, int face_size) {
    DenseCoefficients dense{face_size, {}};
    dense.values.resize(coefficient_count(face_size));
    CoefficientSum sum(face_size);
    for (int channel = 0; channel < 3; ++channel) {
        CubemapTree one;
        for (std::size_t face = 0; face < cubemap_faces; ++face) {
            one.faces[face].scaling = f.faces[face].scaling[channel];
            for (const auto& node : f.faces[face].nodes)
                one.faces[face].nodes.push_back(
                    {{node.wavelet[0][channel], node.wavelet[1][channel], node.wavelet[2][channel]},
                     node.children});
        }
        sum.clear();
        sum.add(one, 1);
        for (const std::uint32_t index : sum.indices())
            dense.values[index][std::size_t(channel)] = sum[index];
    }
    return dense;
}

DenseCoefficients weighted_sum(std::span<const DenseCoefficients* const> functions,
                               std::span<const float> weights) {
    assert(!functions.empty() && functions.size() == weights.size());
    DenseCoefficients sum{functions[0]->face_size, {}};
    sum.values.resize(functions[0]->values.size());
    for (std::size_t f = 0; f < functions.size(); ++f) {
        assert(functions[f]->face_size == sum.face_size);
        for (std::size_t i = 0; i < sum.values.size(); ++i)
            for (std::size_t c = 0; c < 4; ++c) sum.values[i][c] += weights[f] * functions[f]->values[i][c];
    }
    return sum;
}

CoefficientSpectrum rms_spectrum(const DenseCoefficients& f) {
    SpectrumEnergies energies{};
    const BlockNumbers numbers(f.face_size);
    for (std::uint32_t index = 0; index < f.values.size(); ++index)
        for (const float channel : f.values[index])
            energies[spectrum_place(numbers, index)] += double(channel) * channel;
    return root_mean_squares(energies, 3);
}

CoefficientSpectrum rms_spectrum(const SparseVectorBlocks& functions) {
    if (functions.rows == 0) return {};
    const int face_size = functions.blocks[0].face_size;
    const BlockNumbers numbers(face_size);
    std::vector<std::uint8_t> place(coefficient_count(face_size));
    for (std::uint32_t index = 0; index < place.size(); ++index)
        place[index] = static_cast<std::uint8_t>(spectrum_place(numbers, index));
    std::vector<SpectrumEnergies> of_block(functions.blocks.size(), SpectrumEnergies{});
    tbb::parallel_for(std::size_t(0), of_block.size(), [&](std::size_t b) {
        const SparseVectors& block = functions.blocks[b];
        for (std::size_t row = 0; row < block.rows(); ++row)
            block.for_each(row, [&](std::uint32_t index, float value) {
                of_block[b][place[index]] += double(value) * double(value);
            });
    });
    SpectrumEnergies energies{};
    for (const SpectrumEnergies& block : of_block)
        for (std::size_t p = 0; p < energies.size(); ++p) energies[p] += block[p];
    return root_mean_squares(energies, double(functions.rows) * functions.blocks[0].channels);
}

}  // namespace haarfield
