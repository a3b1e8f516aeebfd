#pragma once
/// The pixel domain baseline: every texel of every function, with vector instructions.
///
/// Texels are reordered so that 64 consecutive ones are a square of 8 x 8. Blocks that are completely
/// occluded are then frequent, and skipped. Vectors have the machine's length (Highway). Faces have at least
/// 8 x 8 texels.

#include <hwy/aligned_allocator.h>

#include <cstdint>
#include <span>
#include <vector>

#include "fields/base/vector.h"

namespace haarfield::baseline {

template <class T>
using AlignedArray = hwy::AlignedFreeUniquePtr<T[]>;

/// Lighting texels by channel, in blocks. Shared by all vertices.
struct DenseLight {
    std::size_t texels = 0;
    AlignedArray<float> channel[3];
};

/// The other functions of a vertex, in blocks: own visibility times cosine, BRDF, visibility around each
/// other object.
struct DenseFloats {
    std::vector<AlignedArray<float>> factors;
};

/// Like DenseFloats, with 8 bits for values up to 1: own visibility times cosine in units of 1/255, and
/// visibility as counts of the eight samples, which is exact. The BRDF uses half floats.
struct DenseBytes {
    AlignedArray<std::uint8_t> own;
    AlignedArray<std::uint16_t> brdf;
    std::vector<AlignedArray<std::uint8_t>> visibility;
};

/// Like DenseBytes, with one bit for visibility: open if at least half of the samples are. There is one bit
/// plane per function; the planes are only combined when their words are read.
struct DenseBits {
    AlignedArray<std::uint8_t> own;
    AlignedArray<std::uint16_t> brdf;
    std::vector<AlignedArray<std::uint64_t>> open;  ///< Own visibility times cosine > 0, then visibility.
};

DenseLight dense_light(std::span<const Rgb> texels);
DenseFloats dense_floats(std::span<const std::vector<float>> factors);
DenseBytes dense_bytes(std::span<const std::vector<float>> factors);
DenseBits dense_bits(std::span<const std::vector<float>> factors);

/// Returns the sum over all texels of light * factors, as a mean over each face (6 * size^2 texels), summed
/// over the faces. A scalar loop.
Rgb dense_product_scalar(const DenseLight& light, const DenseFloats& vertex);

/// Returns the same sum, computed with vector instructions.
Rgb dense_product(const DenseLight& light, const DenseFloats& vertex);

/// With vector instructions. Lighting and BRDF of a block are read only if any of its texels is open.
Rgb dense_product_of_open(const DenseLight& light, const DenseFloats& vertex);
Rgb dense_product(const DenseLight& light, const DenseBytes& vertex);
Rgb dense_product(const DenseLight& light, const DenseBits& vertex);

}  // namespace haarfield::baseline
