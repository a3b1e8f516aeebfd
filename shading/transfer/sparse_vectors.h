#pragma once
/// Functions of direction as short lists of coefficients, for repeated multiplication.
///
/// Basis   orthonormal Haar wavelets on each face: amplitude * 2^-level; quadtree.h defines amplitudes. The
///         integral <f, g> over the unit squares of the six faces is therefore the sum of products.
/// Index   16 * block + slot, with blocks numbered by BlockNumbers and slots as in WaveletBlock. Slot 0 is
///         the mean of a face in its root block, and unused in other blocks.

#include "shading/walk/wavelet_blocks.h"

namespace haarfield {

/// Returns the number of indices of a cubemap's coefficients, including unused ones. face_size >= 2.
inline std::uint32_t coefficient_count(int face_size) {
    return static_cast<std::uint32_t>(BlockNumbers(face_size).count() * wide_cells);
}

/// Root mean square of the coefficients of a kind of function, by level: the importance of coefficients of
/// the other factor. 0: the mean of a face; l + 1: level l. [f]
using CoefficientSpectrum = std::array<float, 9>;

/// Returns the place in a CoefficientSpectrum of a slot in a block of a level.
constexpr std::size_t spectrum_place(int block_level, std::size_t slot) {
    return slot == 0 ? 0 : static_cast<std::size_t>(2 * block_level) + (slot % 4 == 0 ? 1 : 2);
}

/// Returns the factor from an amplitude to its coefficient: 2^-level; 0 for unused slots.
float coefficient_of_amplitude(int block_level, std::size_t slot);

int level_of_block(const BlockNumbers& numbers, std::size_t block);  ///< Returns the level of a block.

/// Returns the number of coefficients of a cubemap at a place of a CoefficientSpectrum.
double coefficients_at(std::size_t place);

/// Returns the place in a CoefficientSpectrum of an index.
std::size_t spectrum_place(const BlockNumbers& numbers, std::uint32_t index);

/// A function under construction, by all of its coefficients. Reuses its memory between functions.
class CoefficientSum {
public:
    explicit CoefficientSum(int face_size);  ///< The zero function.

    void clear();  ///< Resets to the zero function; keeps the memory.

    /// Adds weight * f.
    void add(const CubemapTree& f, float weight);
    /// Adds to one coefficient.
    void add(std::uint32_t index, float value);

    /// Returns the coefficients that were added to, in the order of their first addition.
    std::span<const std::uint32_t> indices() const { return indices_; }
    /// Returns a coefficient; zero if nothing was added to it.
    float operator[](std::uint32_t index) const { return values_[index]; }

    int face_size() const { return face_size_; }  ///< Texels along an edge.

private:
    int face_size_;
    BlockNumbers numbers_;
    std::vector<float> values_;           ///< By index; zero except at indices_.
    std::vector<std::uint8_t> is_known_;  ///< By index.
    std::vector<std::uint32_t> indices_;
    std::vector<std::uint32_t> squares_;  ///< By tree node: 4^level + Morton number.
};

/// Functions of one kind, one per row, by their nonzero coefficients in half precision.
///
/// Layout  arrays without pointers: 2 bytes per index, and 2 bytes per value of each channel. An index is
///         relative to its page of 65,536 indices; there is one page up to face size 64.
struct SparseVectors {
    int face_size = 64;
    int channels = 1;                     ///< Values per coefficient: 1, or 3 for RGB.
    std::vector<std::uint32_t> first{0};  ///< By row * pages + page: start of the coefficients.
    std::vector<std::uint16_t> index;
    std::vector<std::uint16_t> value;  ///< IEEE half floats, `channels` per index. [f / scale]
    std::vector<float> scale;          ///< By row: its largest magnitude.

    SparseVectors() = default;
    /// Creates an object without rows.
    SparseVectors(int size, int channel_count) : face_size(size), channels(channel_count) {}

    /// Returns the number of pages of 65,536 indices.
    std::size_t pages() const { return (coefficient_count(face_size) + 0xffffu) >> 16; }
    std::size_t rows() const { return scale.size(); }  ///< Number of functions.
    std::size_t bytes() const;                         ///< Memory. [bytes]

    /// Appends a row: indices in any order, and `channels` values for each. Values are rounded to 2^-11
    /// relative to themselves, or to 2^-25 of the row's largest.
    void append(std::span<const std::uint32_t> indices, std::span<const float> values);
    void append(const CoefficientSum& f);    ///< Appends a function with all of its coefficients.
    void append_empty() { append({}, {}); }  ///< Appends the zero function.

    /// Removes the rows; keeps the memory.
    void clear();

    /// Calls use(place, index) for each coefficient of a row; place is the position in `index`.
    template <class Use>
    void for_each_index(std::size_t row, const Use& use) const;

    /// Calls use(index, value) for each coefficient of a row, and each channel.
    template <class Use>
    void for_each(std::size_t row, const Use& use) const;
};

/// Many rows, in blocks that are computed and used independently.
struct SparseVectorBlocks {
    static constexpr std::size_t block_rows = 256;  ///< Rows of each block except the last.

    std::size_t rows = 0;
    std::vector<SparseVectors> blocks;

    SparseVectorBlocks() = default;
    /// Creates rows whose blocks are to be filled.
    SparseVectorBlocks(std::size_t row_count, int face_size, int channels);

    /// Returns the block of a row.
    const SparseVectors& block_of(std::size_t row) const { return blocks[row / block_rows]; }
    /// Tests whether a row is zero.
    bool is_empty(std::size_t row) const { return block_of(row).scale[row % block_rows] == 0; }
    std::size_t bytes() const;         ///< Memory. [bytes]
    std::size_t coefficients() const;  ///< Number of stored coefficients in all rows.
};

/// An RGB function by all of its coefficients, each as red, green, blue, 0.
struct DenseCoefficients {
    int face_size = 64;
    std::vector<std::array<float, 4>> values;  ///< coefficient_count(face_size) of them. [f]
};

/// Returns all coefficients of an RGB function, by index.
DenseCoefficients dense_coefficients(const RgbCubemapTree& f, int face_size);

/// Returns sum_i weights[i] * functions[i] for one or more functions of one face size (asserted).
DenseCoefficients weighted_sum(std::span<const DenseCoefficients* const> functions,
                               std::span<const float> weights);

/// Selects energies by dropping the smallest, up to a sum of  error^2  of all. Returns their places, the
/// largest first; all if error is 0.
std::vector<std::uint32_t> largest_energies(std::span<const double> energies, float error);

/// Sums of squares by level.
using SpectrumEnergies = std::array<double, std::tuple_size_v<CoefficientSpectrum>>;

/// Converts sums over a number of functions to root mean squares.
CoefficientSpectrum root_mean_squares(const SpectrumEnergies& sums, double functions);

/// Returns the spectrum of one function, over its channels.
CoefficientSpectrum rms_spectrum(const DenseCoefficients& f);
/// Returns the spectrum over all functions of the vectors.
CoefficientSpectrum rms_spectrum(const SparseVectorBlocks& functions);

/// Returns the value of a finite IEEE half float.
inline float half_value(std::uint16_t bits) {
    // The exponent bias is 15 instead of 127; the product is exact.
    const float magnitude = std::bit_cast<float>((bits & 0x7fffu) << 13) * 0x1p112f;
    return (bits & 0x8000u) != 0 ? -magnitude : magnitude;
}

template <class Use>
void SparseVectors::for_each_index(std::size_t row, const Use& use) const {
    const std::size_t page_count = pages();
    for (std::size_t page = 0; page < page_count; ++page)
        for (std::size_t i = first[row * page_count + page]; i < first[row * page_count + page + 1]; ++i)
            use(i, static_cast<std::uint32_t>(page << 16 | index[i]));
}

template <class Use>
void SparseVectors::for_each(std::size_t row, const Use& use) const {
    for_each_index(row, [&](std::size_t place, std::uint32_t at) {
        for (std::size_t c = 0; c < std::size_t(channels); ++c)
            use(at, half_value(value[place * std::size_t(channels) + c]) * scale[row]);
    });
}

}  // namespace haarfield
