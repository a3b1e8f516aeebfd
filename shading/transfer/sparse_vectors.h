#pragma once
/// Functions of direction as short lists of coefficients: what is left of a tree once it is to be multiplied
/// again and again.
///
/// Basis   orthonormal Haar wavelets on each face: amplitude * 2^-level, quadtree.h has the amplitudes. So
///         <f, g>, the integral over the unit squares of the six faces, is the plain sum of products.
/// Index   16 * block + slot, with blocks numbered by BlockNumbers and slots as in WaveletBlock: slot 0 is
///         the mean of a face in the block of its root, and unused in all others.

#include "shading/walk/wavelet_blocks.h"

namespace haarfield {

/// Indices of a cubemap's coefficients, unused ones included. face_size >= 2.
inline std::uint32_t coefficient_count(int face_size) {
    return static_cast<std::uint32_t>(BlockNumbers(face_size).count() * wide_cells);
}

/// Root mean square of a kind of function's coefficients, by level: how much a coefficient of the other
/// factor matters. 0: the mean of a face; l + 1: level l. [f]
using CoefficientSpectrum = std::array<float, 9>;

/// Place in a CoefficientSpectrum of a slot of a block of a level.
constexpr std::size_t spectrum_place(int block_level, std::size_t slot) {
    return slot == 0 ? 0 : static_cast<std::size_t>(2 * block_level) + (slot % 4 == 0 ? 1 : 2);
}

/// From an amplitude to its coefficient: 2^-level; 0 in slots that are unused.
float coefficient_of_amplitude(int block_level, std::size_t slot);

int level_of_block(const BlockNumbers& numbers, std::size_t block);  ///< The level of a numbered block.

/// How many coefficients of a cubemap share a place in a CoefficientSpectrum.
double coefficients_at(std::size_t place);

/// Place in a CoefficientSpectrum of an index.
std::size_t spectrum_place(const BlockNumbers& numbers, std::uint32_t index);

/// One function while it is made or changed, by all of its coefficients. Keeps its memory from one to the
/// next.
class CoefficientSum {
public:
    explicit CoefficientSum(int face_size);  ///< The zero function.

    void clear();  ///< Back to the zero function; memory stays.

    /// Adds weight * f.
    void add(const CubemapTree& f, float weight);
    /// Adds to one coefficient.
    void add(std::uint32_t index, float value);

    /// Coefficients that were added to, in the order of their first addition.
    std::span<const std::uint32_t> indices() const { return indices_; }
    /// A coefficient; zero where nothing was added.
    float operator[](std::uint32_t index) const { return values_[index]; }

    int face_size() const { return face_size_; }  ///< Texels along an edge.

private:
    int face_size_;
    BlockNumbers numbers_;
    std::vector<float> values_;           ///< By index; zero but at indices_.
    std::vector<std::uint8_t> is_known_;  ///< By index.
    std::vector<std::uint32_t> indices_;
    std::vector<std::uint32_t> squares_;  ///< Of a tree's nodes: 4^level + Morton number.
};

/// Functions of one kind, one a row, by their non-zero coefficients in half precision.
///
/// Layout  arrays, no pointers: 2 bytes an index and 2 a value of each channel. An index counts from the
///         start of its page of 65,536 indices, of which there is one up to face size 64.
struct SparseVectors {
    int face_size = 64;
    int channels = 1;                     ///< Values a coefficient: 1, or 3 for RGB.
    std::vector<std::uint32_t> first{0};  ///< By row * pages + page: where its coefficients start.
    std::vector<std::uint16_t> index;
    std::vector<std::uint16_t> value;  ///< IEEE half floats, `channels` an index. [f / scale]
    std::vector<float> scale;          ///< By row: its largest value.

    SparseVectors() = default;
    /// No rows yet.
    SparseVectors(int size, int channel_count) : face_size(size), channels(channel_count) {}

    /// Of 65536 indices.
    std::size_t pages() const { return (coefficient_count(face_size) + 0xffffu) >> 16; }
    std::size_t rows() const { return scale.size(); }  ///< How many functions there are.
    std::size_t bytes() const;                         ///< Memory. [bytes]

    /// Appends a row: indices in any order, and `channels` values of each. Values are rounded to 2^-11 of
    /// themselves, or to 2^-25 of the row's largest.
    void append(std::span<const std::uint32_t> indices, std::span<const float> values);
    void append(const CoefficientSum& f);    ///< Appends a function with all of its coefficients.
    void append_empty() { append({}, {}); }  ///< Appends the zero function.

    /// Forgets the rows, and keeps the memory.
    void clear();

    /// Calls use(place, index) for each coefficient of a row; place: in `index`.
    template <class Use>
    void for_each_index(std::size_t row, const Use& use) const;

    /// Calls use(index, value) for each coefficient of a row, and each channel.
    template <class Use>
    void for_each(std::size_t row, const Use& use) const;
};

/// Many rows, in blocks that can be made and used independently.
struct SparseVectorBlocks {
    static constexpr std::size_t block_rows = 256;  ///< Of each block but the last.

    std::size_t rows = 0;
    std::vector<SparseVectors> blocks;

    SparseVectorBlocks() = default;
    /// Of so many rows, whose blocks are still to be filled.
    SparseVectorBlocks(std::size_t row_count, int face_size, int channels);

    /// The block that a row is in.
    const SparseVectors& block_of(std::size_t row) const { return blocks[row / block_rows]; }
    /// Whether a row is zero.
    bool is_empty(std::size_t row) const { return block_of(row).scale[row % block_rows] == 0; }
    std::size_t bytes() const;         ///< Memory. [bytes]
    std::size_t coefficients() const;  ///< How many are kept, of all rows.
};

/// An RGB function by all of its coefficients, each as red, green, blue, 0.
struct DenseCoefficients {
    int face_size = 64;
    std::vector<std::array<float, 4>> values;  ///< coefficient_count(face_size) of them. [f]
};

/// All coefficients of a colour function, by index.
DenseCoefficients dense_coefficients(const RgbCubemapTree& f, int face_size);

/// sum_i weights[i] * functions[i]; of one face size, at least one (asserted).
DenseCoefficients weighted_sum(std::span<const DenseCoefficients* const> functions,
                               std::span<const float> weights);

/// Which energies are kept if the smallest ones are left out, that add up to at most  error^2  of all: their
/// places, the largest first. All of them if error is 0.
std::vector<std::uint32_t> largest_energies(std::span<const double> energies, float error);

/// Sums of squares by level.
using SpectrumEnergies = std::array<double, std::tuple_size_v<CoefficientSpectrum>>;

/// From sums over a number of functions.
CoefficientSpectrum root_mean_squares(const SpectrumEnergies& sums, double functions);

/// Over the channels; of all rows of a set.
CoefficientSpectrum rms_spectrum(const DenseCoefficients& f);
/// Over all of the vectors' functions.
CoefficientSpectrum rms_spectrum(const SparseVectorBlocks& functions);

/// Value of an IEEE half float that is finite.
inline float half_value(std::uint16_t bits) {
    // The exponent is counted from -15 instead of -127; the product is exact.
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
