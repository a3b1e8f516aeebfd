#pragma once
/// The integral of lighting times any number of functions, sixteen cells at a time.

#include "shading/walk/light_pyramid.h"
#include "shading/walk/wide_walk.h"

namespace haarfield {

/// I = int light f_1 ... f_k dw over the sphere, per channel, in one walk (the lighting holds the solid
/// angle).
///
/// factors   any number; made from faces of the lighting's size.
/// depth     nodes of the quadtrees at level >= depth are treated as absent: coarser and faster. >= 0.
/// memory    of one thread, reused: nothing is allocated once it has grown.
/// returns   I, in the product of the factors' units.
/// accuracy  exact for the stored means up to rounding: 1e-6 of the product of the factors' L2 norms; 1e-5
///           between instruction sets.
/// cost      O(blocks on which at least two functions vary and none is zero).
/// source    Sun and Mukherjee 2006, section 5.1, in another form: the functions are piecewise constant, so
///           the integral over a square is the sum over its cells, and where at most one function varies it
///           is the product of the means.
Rgb product_integral(const LightPyramid& light, std::span<const WeightedTrees<float>> factors, int depth,
                     WalkMemory<float>& memory);

/// product_integral at many points, for trees that come from memory: those of several points are prefetched,
/// read from end to end, before they are walked.
///
/// factors    by point; trees whose WideFace::nodes is not known are not prefetched.
/// integrals  overwritten, as many.
/// cost       against product_integral a third less if a point's trees lie side by side in memory, and a
///            tenth more if they were in the cache.
void product_integrals(const LightPyramid& light,
                       std::span<const std::span<const WeightedTrees<float>>> factors, int depth,
                       WalkMemory<float>& memory, std::span<Rgb> integrals);

/// Haar amplitudes (quadtree.h) of one square and its quadrants, by channel.
///
/// Slot 0 is the mean over the square, slots 4, 8 and 12 its wavelets along x, along y and diagonal; slots
/// 4 Q + 1, 2 and 3 are those of quadrant Q. With l the block's level the square's wavelets are at level 2 l
/// of the quadtree, the quadrants' at 2 l + 1.
template <int channels>
struct WaveletBlock {
    std::uint32_t block;   ///< Its number: BlockNumbers.
    std::uint32_t parent;  ///< Place in the list; of a face's root: its own.
    std::uint16_t cell;    ///< Of the parent.
    std::uint16_t level;   ///< Of blocks: 0 for a face's root.
    std::array<std::array<float, wide_cells>, channels> amplitude;

    WaveletBlock() {}  // NOLINT: of thousands a vertex, whose values are written next, none is cleared first
};

/// Which details of a product do not matter: by level of blocks, what lies below one of its cells.
///
/// Wavelets are orthonormal, so that the squares of the coefficients below a cell add up to the mean square
/// of what the product deviates by from its mean there, times the cell's share of the face.
struct DetailWeights {
    std::array<float, 4> weight{};      ///< From a mean square to an energy: at least.
    std::array<float, 4> negligible{};  ///< Root mean square deviations up to here are left out.
};

/// T = light f_1 ... f_k, untruncated, as the blocks that hold its wavelets, parents before children. Blocks
/// that are absent are zero; of every face the root is there. `product` is overwritten, its memory reused.
///
/// factors, depth, memory, accuracy  as in product_integral.
/// cost    O(blocks on which any function varies and none is zero).
/// source  Sun and Mukherjee 2006, section 5.2. Means of the product are written top-down, then transformed
///         bottom-up; this needs no scatter to the ancestors of every node.
void function_product(const LightPyramid& light, std::span<const WeightedTrees<float>> factors, int depth,
                      WalkMemory<float>& memory, std::vector<WaveletBlock<3>>& product);

/// T = f_1 ... f_k. face_size: that the factors were made from.
void function_product(int face_size, std::span<const WeightedTrees<float>> factors, int depth,
                      WalkMemory<float>& memory, std::vector<WaveletBlock<1>>& product);

}  // namespace haarfield
