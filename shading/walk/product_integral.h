#pragma once
/// The product integral of n functions of direction, and the function product.
///
///     texels --haar_cubemap--> CubemapTree --> WideCubemapTree --> WeightedTrees<float>: a factor
///     lighting: RgbCubemapTree --> LightPyramid
///     factors --> product_integral:  I = int f_1 ... f_n, a number
///             --> function_product:  f_1 ... f_n, wavelet blocks --cubemap_tree--> CubemapTree
///
/// A factor is one tree (WideCubemapTree::factor), or a constant plus a weighted sum of trees. The latter
/// represents a visibility between the samples of a field without computing its tree. Trees may be factors of
/// any number of products in any number of threads; each thread needs its own WalkMemory.

#include "shading/walk/light_pyramid.h"
#include "shading/walk/wavelet_blocks.h"
#include "shading/walk/wide_walk.h"

namespace haarfield {

/// Computes I = int f_1 f_2 ... f_n dA, added over the six faces; dA is a fraction of the face. That is the
/// integral over the sphere if exactly one of the factors contains the texels' solid angles (lighting.h).
///
/// face_size  texels along an edge of the factors, is_face_size.
/// factors    any number; the product of none is 1.
/// depth      nodes of the quadtrees at level >= depth are ignored: coarser and faster. >= 0.
/// memory     of one thread, reused: nothing is allocated once it has grown.
/// returns    I, in the product of the factors' units.
/// accuracy   exact for the means that the wide trees store, up to rounding: 1e-6 of the integral of the
///            product's magnitude; 1e-5 between instruction sets.
/// cost       O(blocks on which at least two functions vary and none is zero): some microseconds for six
///            functions on faces of 64 x 64 texels.
/// source     Sun and Mukherjee 2006, section 5.1, in another form. The functions are piecewise constant, so
///            the integral over a square is the sum over its cells. Where at most one function varies, it is
///            the product of the means.
float product_integral(int face_size, std::span<const WeightedTrees<float>> factors, int depth,
                       WalkMemory<float>& memory);

/// Computes I = int light f_1 ... f_n dw over the sphere, per channel: the lighting contains the solid angle.
/// face_size is the lighting's.
Rgb product_integral(const LightPyramid& light, std::span<const WeightedTrees<float>> factors, int depth,
                     WalkMemory<float>& memory);

/// Computes product integrals of many points whose trees are not in the cache. Before they are walked, the
/// trees of several points are prefetched by reading them sequentially.
///
/// factors    by point; trees of unknown WideFace::nodes are not prefetched.
/// integrals  overwritten; one per point.
/// cost       a third less than product_integral if the trees of a point are contiguous in memory; a tenth
///            more if they are in the cache.
void product_integrals(const LightPyramid& light,
                       std::span<const std::span<const WeightedTrees<float>>> factors, int depth,
                       WalkMemory<float>& memory, std::span<Rgb> integrals);

/// Computes T = light f_1 ... f_k without truncation, as the blocks that hold its wavelets, parents before
/// children. Absent blocks are zero; the root of every face is present. `product` is overwritten and its
/// memory reused.
///
/// factors, depth, memory, accuracy  as in product_integral.
/// cost    O(blocks on which any function varies and none is zero).
/// source  Sun and Mukherjee 2006, section 5.2. Means of the product are written top-down, then transformed
///         bottom-up; no node contributes to all of its ancestors.
void function_product(const LightPyramid& light, std::span<const WeightedTrees<float>> factors, int depth,
                      WalkMemory<float>& memory, std::vector<WaveletBlock<3>>& product);

/// Computes T = f_1 ... f_k. face_size: texels along an edge of the factors.
void function_product(int face_size, std::span<const WeightedTrees<float>> factors, int depth,
                      WalkMemory<float>& memory, std::vector<WaveletBlock<1>>& product);

}  // namespace haarfield
