#pragma once
/// Which instances of a scene may be seen from a place.

#include "fields/mesh/mesh.h"

#include <span>

namespace haarfield {

/// A ball.
struct Sphere {
    Vec3f centre;
    float radius = 0;
};

/// A uniform grid over spheres.
class InstanceGrid {
public:
    /// where   the points that will be asked for, but for a few: the cells divide what of this box the
    ///         spheres reach.
    /// memory  at most some 64 cells a sphere, and a number for each sphere that touches a cell: cells are as
    ///         large as to have no more than some 64 of these a sphere, too, or else there is a single one.
    explicit InstanceGrid(std::span<const Sphere> spheres,
                          const Bounds& where = {Vec3f(-INFINITY), Vec3f(INFINITY)});

    /// The spheres, by number and in ascending order, whose boxes touch the cell of a point: all that contain
    /// the point, and a few more.
    ///
    /// cost    a look-up.
    std::span<const std::uint32_t> near(const Vec3f& point) const;

    std::size_t cell_count() const { return first_.size() - 1; }  ///< All along x, y and z.

private:
    void set_cells(double wanted);
    double touched_cells(std::span<const Sphere> spheres) const;
    int cell(float coordinate, int axis) const;

    Bounds reached_,
        bounds_;  ///< Of all spheres; what the cells divide. Farther points have the nearest cell.
    std::array<int, 3> cells_{1, 1, 1};
    Vec3f cells_per_metre_{0, 0, 0};
    std::vector<std::uint32_t> first_, sphere_;
};

}  // namespace haarfield
