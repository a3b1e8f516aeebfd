#pragma once
/// A grid that finds the instances that may occlude a point.

#include "fields/mesh/mesh.h"

#include <span>

namespace haarfield {

/// A sphere.
struct Sphere {
    Vec3f centre;
    float radius = 0;
};

/// A uniform grid over spheres.
class InstanceGrid {
public:
    /// Builds the grid.
    ///
    /// where   box of most query points: the cells divide its intersection with the bounds of the spheres.
    /// memory  at most about 64 cells per sphere, and 4 bytes for each sphere in each cell that it touches.
    ///         Cells are large enough that there are about 64 such entries per sphere at most, unless a
    ///         single cell is left.
    explicit InstanceGrid(std::span<const Sphere> spheres,
                          const Bounds& where = {Vec3f(-INFINITY), Vec3f(INFINITY)});

    /// Returns the spheres whose boxes touch the cell of a point, by index in ascending order: all that
    /// contain the point, and a few more.
    ///
    /// cost    one lookup.
    std::span<const std::uint32_t> near(const Vec3f& point) const;

    std::size_t cell_count() const { return first_.size() - 1; }  ///< All cells of the grid.

private:
    void set_cells(double wanted);
    double touched_cells(std::span<const Sphere> spheres) const;
    int cell(float coordinate, int axis) const;

    /// Bounds of all spheres; bounds of the cells. Points outside the cells use the nearest cell.
    Bounds reached_, bounds_;
    std::array<int, 3> cells_{1, 1, 1};
    Vec3f cells_per_metre_{0, 0, 0};
    std::vector<std::uint32_t> first_, sphere_;
};

}  // namespace haarfield
