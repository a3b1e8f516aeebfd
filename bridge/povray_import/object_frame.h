#pragma once
/// The grid of one sampled object. Internal.

#include "bridge/povray_import/object_surfaces.h"

namespace haarfield {

/// Three coordinate systems: the scene's; an object's local ones, in which POV-Ray traces it; and the grid's,
/// in which cells are cubes of side 1, from 0 to `cells`. Local and grid coordinates are equal, except for
/// objects that are cut: their cells grow with the distance from the centre.
struct GridFrame {
    std::array<int, 3> cells{1, 1, 1};
    Vec3d centre{0, 0, 0};  ///< In the scene; becomes `shift` in local coordinates.
    Vec3d scale{1, 1, 1};   ///< Local units per unit of the scene, by axis.
    Vec3d shift{0, 0, 0};
    double warp_size = 0,
           warp_rate = 0;  ///< local = shift + warp_size sinh(warp_rate (grid - cells / 2)); 0: none.

    Vec3d local_point(const Vec3d& scene) const { return (scene - centre) * scale + shift; }  ///< Of a point.
    Vec3d local_normal(const Vec3d& scene) const { return (scene / scale).normalized(); }  ///< Of a normal.
    /// Returns a point of the grid in the scene.
    Vec3d scene_point(const Vec3d& grid) const;
    /// Returns a normal at a point of the grid, in the scene.
    Vec3d scene_normal(const Vec3d& grid, const Vec3d& normal) const;
    double local_coordinate(int axis, double grid) const;  ///< Of one axis.
    double grid_coordinate(int axis, double local) const;  ///< Of one axis.
    double local_per_grid(int axis, double grid) const;    ///< The derivative of local_coordinate.
};

/// Returns the grid of a request.
GridFrame grid_frame(const GridRequest& request);

/// The output of POV-Ray for the lines of some grids.
struct TracedLines {
    std::vector<std::string> lines;  ///< By request, for crossed_grid; empty: POV-Ray did not finish.
    std::vector<std::size_t> slow;   ///< As ObjectSurfaces::slow.
};

/// Traces the lines of the grids of objects; see object_surfaces.
Result<TracedLines> traced_lines(const SceneQueries& queries, std::span<const GridRequest> requests,
                                 double object_seconds, const Progress& progress);

/// Returns the crossings of an object, in grid coordinates; none if `lines` is incomplete.
std::optional<CrossedGrid> crossed_grid(const GridFrame& frame, const std::string& lines);

/// Makes all crossings those of sheets.
void take_for_sheets(CrossedGrid& grid);

/// Returns the contoured surface in the scene's coordinates, without colours.
ObjectSurface contoured_surface(const GridFrame& frame, const CrossedGrid& grid, std::size_t object);

/// Returns the contoured surface of an object, as sheets if it is open.
ObjectSurface closed_or_open_surface(const GridFrame& frame, CrossedGrid grid, std::size_t object);

}  // namespace haarfield
