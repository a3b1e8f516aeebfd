#pragma once
/// The product integral of n functions of direction, and their product, again a function of direction.
///
///     texels --haar_cubemap--> CubemapTree --> WideCubemapTree --> WeightedTrees<float>: a factor
///     lighting: RgbCubemapTree --> LightPyramid
///     factors --> product_integral:  I = int f_1 ... f_n, a number
///             --> function_product:  f_1 ... f_n, wavelet blocks --cubemap_tree--> CubemapTree
///
/// A factor is one tree (WideCubemapTree::factor), or a constant and a weighted sum of trees, such as a
/// visibility between the samples of a field, which need not be made. Trees are made once and may be factors
/// of as many products as wanted, in as many threads: only the memory of a walk is a thread's own.

#include "shading/walk/light_pyramid.h"
#include "shading/walk/wavelet_blocks.h"
#include "shading/walk/wide_walk.h"

namespace haarfield {

/// I = int f_1 f_2 ... f_n dA, added over the six faces; dA is a fraction of the face. That is the integral
/// over the sphere if exactly one of the factors holds the texels' solid angles (lighting.h).
///
/// face_size  texels along an edge that the factors were made from, is_face_size.
/// factors    any number; of none the product is 1.
/// depth      nodes of the quadtrees at level >= depth are treated as absent: coarser and faster. >= 0.
/// memory     of one thread, reused: nothing is allocated once it has grown.
/// returns    I, in the product of the factors' units.
/// accuracy   exact for the means that the wide trees hold, up to rounding: 1e-6 of the integral of the
///            product's magnitude; 1e-5 between instruction sets.
/// cost       O(blocks on which at least two functions vary and none is zero): some microseconds for six
///            functions on faces of 64 x 64 texels.
/// source     Sun and Mukherjee 2006, section 5.1, in another form: the functions are piecewise constant, so
///            the integral over a square is the sum over its cells, and where at most one function varies it
///            is the product of the means.
float product_integral(int face_size, std::span<const WeightedTrees<float>> factors, int depth,
                       WalkMemory<float>& memory);

/// The same with lighting as one factor more, per channel: I = int light f_1 ... f_n dw over the sphere, as
/// the lighting holds the solid angle. face_size is the lighting's.
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
