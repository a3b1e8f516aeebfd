#include "fields/base/affine_map.h"

#include <cmath>

namespace haarfield {

Vec3d AffineMap::normal(const Vec3d& n) const {
    // The inverse transpose, up to a positive factor: only the sign of the determinant matters.
    const Vec3d result =
        axes[1].cross(axes[2]) * n.x + axes[2].cross(axes[0]) * n.y + axes[0].cross(axes[1]) * n.z;
    const double length = result.length();
    if (!(length > 0) || !std::isfinite(length)) return Vec3d(0, 0, 0);
    return result / (is_mirrored() ? -length : length);
}

bool AffineMap::is_mirrored() const {
    return axes[0].cross(axes[1]).dot(axes[2]) < 0;
}

std::array<Vec3d, 3> AffineMap::rows() const {
    std::array<Vec3d, 3> rows;
    for (int r = 0; r < 3; ++r) rows[std::size_t(r)] = {axes[0][r], axes[1][r], axes[2][r]};
    return rows;
}

AffineMap operator*(const AffineMap& second, const AffineMap& first) {
    AffineMap result;
    for (std::size_t axis = 0; axis < 3; ++axis) result.axes[axis] = second.direction(first.axes[axis]);
    result.origin = second.point(first.origin);
    return result;
}

}  // namespace haarfield
