#pragma once
/// Functions on a cubemap face and on the whole cubemap, as trees of Haar wavelets.
///
/// Domain      the unit square: texel (0,0) at the origin, x right, y down. dA is a fraction of the face, so
///             the scaling coefficient is the mean of f.
/// Quadrants   of a square, numbered 2y + x: 0 upper left, 1 upper right, 2 lower left, 3 lower right.
/// Wavelets    three per square: along x (+ left, - right), along y (+ top, - bottom), diagonal (+ - / - +).
///             A node stores *amplitudes*: the value that the wavelet adds to f, in the unit of f. The mean
///             of f over quadrant q is
///                 mean + sign[0][q] wavelet[0] + sign[1][q] wavelet[1] + sign[2][q] wavelet[2].
///             At level l (root: 0) the orthonormal coefficient is amplitude * 2^-l. Its contribution to the
///             squared L2 norm of f is amplitude^2 * 4^-l.

#include "fields/base/vector.h"
#include "fields/wavelets/cubemap.h"

#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

namespace haarfield {

/// The sign of a wavelet on a quadrant: [wavelet][quadrant].
inline constexpr std::array<std::array<float, 4>, 3> wavelet_sign{
    {{+1, -1, +1, -1}, {+1, +1, -1, -1}, {+1, -1, -1, +1}}};

/// A function on one cubemap face. Value: float, or Rgb for three channels that share one tree.
template <class Value>
struct BasicQuadtree {
    /// The wavelets of one square.
    struct Node {
        /// Amplitudes along x, along y, and diagonal. [f]
        std::array<Value, 3> wavelet{Value(0.0f), Value(0.0f), Value(0.0f)};
        /// Index of the first child << 4 | mask of the quadrants that have a child. Children are contiguous,
        /// in order of their quadrants.
        std::uint32_t children = 0;
    };
    Value scaling = Value(0.0f);  ///< Mean of f. [f]
    std::vector<Node> nodes;      ///< In level order, root first; empty if f is constant.
};

using Quadtree = BasicQuadtree<float>;   ///< A scalar function.
using RgbQuadtree = BasicQuadtree<Rgb>;  ///< A colour function.

/// The index of a missing child: the function is constant on that quadrant.
inline constexpr std::int32_t no_node = -1;

/// Returns the number of quadrants in a mask. (std::popcount is a library call on baseline instruction sets.)
constexpr std::uint32_t quadrant_count(std::uint32_t mask) {
    constexpr std::array<std::uint8_t, 16> count{0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4};
    return count[mask];
}

/// Returns the index of a node's child in a quadrant, or no_node.
template <class Node>
std::int32_t child_of(const Node& node, unsigned quadrant) {
    const std::uint32_t mask = node.children & 15u;
    if (!(mask >> quadrant & 1u)) return no_node;
    const std::uint32_t before = mask & ((1u << quadrant) - 1u);
    return static_cast<std::int32_t>((node.children >> 4) + quadrant_count(before));
}

/// Returns the mean over a quadrant, given the mean over the square.
template <class Value>
Value quadrant_mean(const Value& mean, const std::array<Value, 3>& wavelet, unsigned quadrant) {
    return mean + wavelet[0] * wavelet_sign[0][quadrant] + wavelet[1] * wavelet_sign[1][quadrant] +
           wavelet[2] * wavelet_sign[2][quadrant];
}

/// A function of direction: one quadtree per cubemap face.
template <class Value>
struct BasicCubemapTree {
    std::array<BasicQuadtree<Value>, cubemap_faces> faces;
};

using CubemapTree = BasicCubemapTree<float>;   ///< A scalar function.
using RgbCubemapTree = BasicCubemapTree<Rgb>;  ///< A colour function.

}  // namespace haarfield
