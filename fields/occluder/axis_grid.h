#pragma once
/// A search structure for the triangles of a mesh that an axis-parallel line intersects.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "fields/base/vector.h"

namespace haarfield {

/// The axes across and up, which form a right-handed frame with a given axis.
struct AxisFrame {
    int across, up;
};
inline constexpr std::array<AxisFrame, 3> axis_frames{{{1, 2}, {2, 0}, {0, 1}}};  ///< Frames of x, y and z.

/// Triangles projected along an axis, in a binary tree of bounds. It holds long triangles, whose boxes cover
/// many cells of a grid although the triangles do not.
///
/// memory  at most 16 bytes per triangle.
struct LongTriangles {
    static constexpr std::size_t leaf_size = 8;

    /// Bounds of some triangles: a box, and a strip along the longest of their edges. The triangles of a fan
    /// or of planks that run diagonally fill their strips, but not their boxes.
    struct Node {
        std::array<float, 2> lower, upper;  ///< Across and up. [m]
        std::array<float, 2> normal;        ///< Unit normal of the strip; 0 if no triangle has an edge.
        float strip_lower, strip_upper;     ///< Dot products of the normal and the points of the strip. [m]
        std::uint32_t next;                 ///< The first node after this subtree, in depth-first order.
        std::uint32_t first, count;         ///< Triangles of a leaf; count is 0 for inner nodes.

        /// True if both the box and the strip contain a point.
        bool may_contain(double across, double up) const;
    };
    std::vector<Node> nodes;              ///< In depth-first order.
    std::vector<std::uint32_t> triangle;  ///< Sorted by leaf.
};

/// The triangles of a mesh, projected along an axis: short ones by the grid cells that their boxes touch,
/// long ones in a tree.
///
/// memory  at most 80 bytes per triangle; about 20 for meshes of similar triangles.
struct AxisGrid {
    /// Triangles whose boxes touch more cells are long.
    static constexpr std::size_t most_cells = 16;

    int cells = 1;  ///< Along an edge.
    std::array<float, 2> lower{}, cells_per_metre{};
    std::vector<std::uint32_t> first, triangle;  ///< Cell c has triangle[first[c]] to [first[c + 1] - 1].
    LongTriangles long_triangles;

    /// Returns the cell of a coordinate across the axis (k = 0) or up (k = 1); outside the grid, the nearest
    /// cell.
    int cell(double coordinate, std::size_t k) const;

    /// Calls visit(triangle) once for each triangle of a superset of those whose projections contain a point.
    ///
    /// accuracy  also finds triangles that contain the point only after the coordinates of their vertices
    ///           relative to the point are rounded to float.
    /// cost      O(log n + visited) for triangles of similar size and for fans and planks of long ones. O(n)
    ///           in the worst case, such as long triangles in random directions.
    template <class Visit>
    void visit_triangles_at(double across, double up, Visit&& visit) const {
        const auto at = static_cast<std::size_t>(cell(up, 1)) * static_cast<std::size_t>(cells) +
                        static_cast<std::size_t>(cell(across, 0));
        for (std::size_t i = first[at]; i < first[at + 1]; ++i) visit(triangle[i]);
        const std::vector<LongTriangles::Node>& nodes = long_triangles.nodes;
        for (std::size_t n = 0; n < nodes.size();) {
            const LongTriangles::Node& node = nodes[n];
            const bool enters = node.may_contain(across, up);
            n = enters ? n + 1 : node.next;
            if (!enters) continue;
            for (std::size_t i = 0; i < node.count; ++i) visit(long_triangles.triangle[node.first + i]);
        }
    }
};

/// Projects triangles along the axis of a frame.
///
/// positions  [m]
/// triangles  indices into positions; fewer than 2^28 triangles
/// cost       O(n) for meshes of similar triangles, O(n log^2 n) for long ones
AxisGrid axis_grid(std::span<const Vec3f> positions, std::span<const std::array<std::uint32_t, 3>> triangles,
                   const AxisFrame& frame);

inline bool LongTriangles::Node::may_contain(double across, double up) const {
    if (!(across >= double(lower[0]) && across <= double(upper[0]) && up >= double(lower[1]) &&
          up <= double(upper[1])))
        return false;
    const double at = double(normal[0]) * across + double(normal[1]) * up;
    return at >= double(strip_lower) && at <= double(strip_upper);
}

}  // namespace haarfield
