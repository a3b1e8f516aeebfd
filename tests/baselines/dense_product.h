#pragma once
/// The pixel domain baseline: every texel of every function, as fast as vector instructions go.
///
/// Texels are reordered so that 64 in a row are a square of 8 x 8: blocks in which everything is hidden are
/// then frequent, and passed over. Vectors of whatever length the machine has (Highway). Faces have at least
/// 8 x 8 texels.

#include <hwy/aligned_allocator.h>

#include <cstdint>
#include <span>
#include <vector>

#include "fields/base/vector.h"

namespace haarfield::baseline {

template <class T>
using AlignedArray = hwy::AlignedFreeUniquePtr<T[]>;

/// Lighting texels by channel, in blocks; shared by all vertices.
struct DenseLight {
    std::size_t texels = 0;
    AlignedArray<float> channel[3];
};

/// The other functions of a vertex in blocks: first own visibility times cosine, then the BRDF, then
/// visibility.
struct DenseFloats {
    std::vector<AlignedArray<float>> factors;
};

/// The same with 8 bits for what is at most 1: own visibility times cosine in 255ths, visibility as counts of
/// the eight samples, which is exact. The BRDF in half floats.
struct DenseBytes {
    AlignedArray<std::uint8_t> own;
    AlignedArray<std::uint16_t> brdf;
    std::vector<AlignedArray<std::uint8_t>> visibility;
};

/// The same with visibility in one bit, open from half of the samples on. `open` is their conjunction with
/// that of own visibility times cosine being positive only after the words have been read: one plane a
/// function.
struct DenseBits {
    AlignedArray<std::uint8_t> own;
    AlignedArray<std::uint16_t> brdf;
    std::vector<AlignedArray<std::uint64_t>> open;  ///< Own visibility times cosine > 0, then visibility.
};

DenseLight dense_light(std::span<const Rgb> texels);
DenseFloats dense_floats(std::span<const std::vector<float>> factors);
DenseBytes dense_bytes(std::span<const std::vector<float>> factors);
DenseBits dense_bits(std::span<const std::vector<float>> factors);

/// Sum over all texels of light * factors, as a mean over each face: 6 * size^2 texels, added over the faces.
/// The plain loop, a texel at a time.
Rgb dense_product_scalar(const DenseLight& light, const DenseFloats& vertex);

/// All of it, in vectors.
Rgb dense_product(const DenseLight& light, const DenseFloats& vertex);

/// In vectors; lighting and BRDF of a block are read only where something is open.
Rgb dense_product_of_open(const DenseLight& light, const DenseFloats& vertex);
Rgb dense_product(const DenseLight& light, const DenseBytes& vertex);
Rgb dense_product(const DenseLight& light, const DenseBits& vertex);

}  // namespace haarfield::baseline
