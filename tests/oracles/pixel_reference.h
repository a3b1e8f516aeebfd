#pragma once
/// Reference implementations on plain texels in double, slow and simple.
/// Includes no product code except structs and conventions in the headers of fields/.

#include <cstdint>
#include <span>
#include <vector>

#include "fields/wavelets/quadtree.h"

namespace haarfield::reference {

using Texels = std::vector<double>;  ///< size * size values in row-major order.

/// Evaluates a tree at the centre of every texel. Nodes at level >= depth are ignored.
Texels texels_of(const Quadtree& tree, int size, int depth = 32);

/// Evaluates one channel (0 red to 2 blue) of a tree.
Texels texels_of(const RgbQuadtree& tree, int channel, int size, int depth = 32);

/// Multiplies texel by texel.
Texels product(std::span<const Texels> factors);

double mean(const Texels& texels);

/// Returns the mean of the absolute values, the reference for rounding errors.
double absolute_mean(const Texels& texels);

/// Returns the *amplitude* of a Haar wavelet, by summation over its square.
///
/// x, y  index of the square, of 2^level along an edge.
/// kind  0 along x, 1 along y, 2 diagonal.
double wavelet_amplitude(const Texels& texels, int size, int level, int x, int y, int kind);

/// Returns a tree of at most `levels` levels of nodes, whose children exist with probability `density`. The
/// mean is between 0.7 and 1.3. Amplitudes are random with both signs, and smaller on finer levels.
Quadtree random_quadtree(std::uint32_t seed, int levels, double density);
RgbQuadtree random_rgb_quadtree(std::uint32_t seed, int levels, double density);

/// Returns `count` trees that depend on the seed. Every fourth one, from the third on, is constant.
std::vector<Quadtree> random_trees(std::uint32_t seed, int count, int levels, double density);

/// Returns pointers for the product integral. The trees must outlive the result.
std::vector<const Quadtree*> pointers(const std::vector<Quadtree>& trees);

/// Returns the coverage of a random half plane, in [0, 1], similar to visibility. Exactly 0 or 1 off the
/// edge.
std::vector<float> half_plane_texels(std::uint32_t seed, int size);

/// Returns independent random values in [0, 1).
std::vector<float> noise_texels(std::uint32_t seed, std::size_t count);

}  // namespace haarfield::reference
