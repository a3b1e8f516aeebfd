#pragma once
/// Meshes of surfaces that are known by their crossings with the lines of a grid.

#include "fields/base/vector.h"

#include <array>
#include <cstdint>
#include <vector>

namespace haarfield {

/// A crossing of a grid line and a surface.
struct LineCrossing {
    double place = 0;                                  ///< Coordinate along the line. [cells]
    Vec3f normal{0, 0, 0};                             ///< Of the surface; unit length, either side.
    bool inside_before = false, inside_after = false;  ///< Equal: a sheet, or a surface within a solid.

    bool is_solid() const { return inside_before != inside_after; }  ///< True at the boundary of a solid.
};

/// A grid of cubic cells with the crossings of all its lines. Points have integer coordinates from 0 to
/// `cells`.
struct CrossedGrid {
    std::array<int, 3> cells{1, 1, 1};
    /// By axis, then by line: the line through the point whose other two coordinates are i (of the next axis,
    /// cyclically) and j has the index i * (cells of the axis after that + 1) + j. Sorted by place.
    std::array<std::vector<std::vector<LineCrossing>>, 3> lines;
    /// By axis and line: 1 if a line without solid crossings is inside; empty: none is.
    std::array<std::vector<std::uint8_t>, 3> inside_lines{};

    /// Returns the number of lines along an axis.
    std::size_t line_count(int axis) const {
        return static_cast<std::size_t>(cells[std::size_t((axis + 1) % 3)] + 1) *
               static_cast<std::size_t>(cells[std::size_t((axis + 2) % 3)] + 1);
    }
};

/// A mesh with a normal per vertex. Vertices on sharp edges occur once for each side.
struct ContouredMesh {
    std::vector<Vec3f> positions;  ///< [cells]
    std::vector<Vec3f> normals;    ///< Unit length; outwards for solids.
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::size_t sheet_triangles = 0;  ///< The last ones, which have no inside.
    std::size_t double_edges = 0;     ///< Grid edges with several crossings: something may have been missed.
    std::size_t missed_edges = 0;     ///< Grid edges whose ends differ, but without a crossing.
    std::size_t lost_edges = 0;       ///< Grid edges whose ends agree, but with an odd number of crossings.
};

/// Returns the surface: one vertex for each piece of it in each cell, at the point that best satisfies the
/// planes of the crossings on the cell's edges. Sharp edges and corners are kept.
///
/// Solids give closed meshes, except where they leave the grid: each point of the grid is inside or outside
/// by the majority of its three lines. Crossings with the same state on both sides give sheets if they are
/// outside, and nothing if they are inside.
///
/// accuracy  smooth surfaces: quadratic in the size of a cell.
/// cost      2 us per cell that the surface crosses, and 10 ns per cell.
/// source    Ju, Losasso, Schaefer and Warren 2002, Dual Contouring of Hermite Data; one vertex per piece as
///           in Schaefer, Ju and Warren 2007, Manifold Dual Contouring.
ContouredMesh dual_contour(const CrossedGrid& grid);

}  // namespace haarfield
