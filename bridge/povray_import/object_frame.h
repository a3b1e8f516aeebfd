#pragma once
/// The grid of one sampled object. Internal.

#include "bridge/povray_import/object_surfaces.h"

namespace haarfield {

/// Grid coordinates: cells are cubes of side 1, from 0 to `cells`.
struct GridFrame {
    std::array<int, 3> cells{1, 1, 1};
    Vec3d centre{0, 0, 0};  ///< In the scene; becomes `shift`.
    Vec3d scale{1, 1, 1};   ///< Cells per unit of the scene, by axis.
    Vec3d shift{0, 0, 0};

    /// Returns a point in the scene.
    Vec3d scene_point(const Vec3d& p) const { return (p - shift) / scale + centre; }
    /// Returns a normal in the scene.
    Vec3d scene_normal(const Vec3d& n) const { return (n * scale).normalized(); }
    /// Returns a point in the grid.
    Vec3d grid_point(const Vec3d& p) const { return (p - centre) * scale + shift; }
    /// Returns a normal in the grid.
    Vec3d grid_normal(const Vec3d& n) const { return (n / scale).normalized(); }
};

/// Returns the grid of a request.
GridFrame grid_frame(const GridRequest& request);

}  // namespace haarfield
