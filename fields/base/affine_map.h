#pragma once
/// Any affine map, in double.

#include "fields/base/vector.h"

#include <array>

namespace haarfield {

/// Where the axes and the origin go to.
struct AffineMap {
    std::array<Vec3d, 3> axes{Vec3d(1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, 0, 1)};
    Vec3d origin{0, 0, 0};

    /// A direction, or the difference of two points, moved.
    Vec3d direction(const Vec3d& d) const { return axes[0] * d.x + axes[1] * d.y + axes[2] * d.z; }
    /// A point, moved.
    Vec3d point(const Vec3d& p) const { return direction(p) + origin; }
    /// A normal, as the surface that it stands on is moved; of another length.
    Vec3d normal(const Vec3d& n) const;
    bool is_mirrored() const;           ///< Turns left hands into right ones.
    std::array<Vec3d, 3> rows() const;  ///< Of the linear part, as a matrix that stands before columns.

    bool operator==(const AffineMap&) const = default;  ///< Equal in all bits, but for signs of zeros.
};

/// `second` after `first`.
AffineMap operator*(const AffineMap& second, const AffineMap& first);

}  // namespace haarfield
