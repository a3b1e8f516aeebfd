#pragma once
/// Affine maps in double precision.

#include "fields/base/vector.h"

#include <array>

namespace haarfield {

/// An affine map: the images of the three axes and of the origin.
struct AffineMap {
    std::array<Vec3d, 3> axes{Vec3d(1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, 0, 1)};
    Vec3d origin{0, 0, 0};

    /// Maps a direction, or the difference of two points.
    Vec3d direction(const Vec3d& d) const { return axes[0] * d.x + axes[1] * d.y + axes[2] * d.z; }
    /// Maps a point.
    Vec3d point(const Vec3d& p) const { return direction(p) + origin; }
    /// Maps a surface normal. Returns a unit vector, or zero if the map is singular.
    Vec3d normal(const Vec3d& n) const;
    bool is_mirrored() const;           ///< True if the map swaps right-handed and left-handed frames.
    std::array<Vec3d, 3> rows() const;  ///< The rows of the linear part, for column vectors.

    bool operator==(const AffineMap&) const = default;  ///< Exact, except that -0 equals 0.
};

/// Returns the composition of two maps: `first`, then `second`.
AffineMap operator*(const AffineMap& second, const AffineMap& first);

}  // namespace haarfield
