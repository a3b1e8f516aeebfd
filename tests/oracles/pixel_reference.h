#pragma once
/// The slow and obvious: functions as plain texels in double, to compare everything else with.
/// Includes no product code beyond the structs and conventions in the headers of fields/.

#include <cstdint>
#include <span>
#include <vector>

#include "fields/wavelets/quadtree.h"

namespace haarfield::reference {

using Texels = std::vector<double>;  ///< size * size values, row by row.

/// What a tree says at the centre of every texel; nodes at level >= depth are left out.
Texels texels_of(const Quadtree& tree, int size, int depth = 32);

/// One channel (0 red to 2 blue) of a tree.
Texels texels_of(const RgbQuadtree& tree, int channel, int size, int depth = 32);

/// Texel by texel.
Texels product(std::span<const Texels> factors);

double mean(const Texels& texels);

/// Mean of the absolute values: what rounding is measured against.
double absolute_mean(const Texels& texels);

/// The *amplitude* of a Haar wavelet, by summing over its square.
///
/// x, y  the square, of 2^level along an edge.
/// kind  0 along x, 1 along y, 2 diagonal.
double wavelet_amplitude(const Texels& texels, int size, int level, int x, int y, int kind);

/// A tree of `levels` levels of nodes at most, whose children exist with probability `density`. Mean
/// between 0.7 and 1.3, amplitudes random with both signs, smaller on finer levels.
Quadtree random_quadtree(std::uint32_t seed, int levels, double density);
RgbQuadtree random_rgb_quadtree(std::uint32_t seed, int levels, double density);

/// `count` of them, different for different seeds; every fourth one, from the third on, is constant.
std::vector<Quadtree> random_trees(std::uint32_t seed, int count, int levels, double density);

/// As the product integral takes them. The trees must outlive the result.
std::vector<const Quadtree*> pointers(const std::vector<Quadtree>& trees);

/// Coverage of a random half plane, in [0, 1]: what visibility looks like. Truly 0 and 1 off the edge.
std::vector<float> half_plane_texels(std::uint32_t seed, int size);

/// Independent random values in [0, 1).
std::vector<float> noise_texels(std::uint32_t seed, std::size_t count);

}  // namespace haarfield::reference
