#include "fields/base/rotation.h"

#include <algorithm>
#include <cmath>

namespace haarfield {

Rotation Rotation::inverse() const {
    Rotation transposed;
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) transposed.row[std::size_t(i)][k] = row[std::size_t(k)][i];
    return transposed;
}

Rotation operator*(const Rotation& second, const Rotation& first) {
    Rotation product;
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) {
            const Vec3d column(first.row[0][k], first.row[1][k], first.row[2][k]);
            product.row[std::size_t(i)][k] = second.row[std::size_t(i)].dot(column);
        }
    return product;
}

// Rodrigues: v cos + (axis x v) sin + axis (axis . v) (1 - cos).
Rotation rotation_about(const Vec3d& axis, double angle) {
    const Vec3d a = axis.normalized();
    const double cosine = std::cos(angle), sine = std::sin(angle);
    Rotation rotation;
    for (int k = 0; k < 3; ++k) {
        Vec3d unit(0.0);
        unit[k] = 1;
        const Vec3d turned = unit * cosine + a.cross(unit) * sine + a * (a[k] * (1 - cosine));
        for (int i = 0; i < 3; ++i) rotation.row[std::size_t(i)][k] = turned[i];
    }
    return rotation;
}

Rotation rotation_xyz(const Vec3f& angles) {
    return rotation_about({0, 0, 1}, double(angles.z)) *
           (rotation_about({0, 1, 0}, double(angles.y)) * rotation_about({1, 0, 0}, double(angles.x)));
}

Vec3f angles_xyz(const Rotation& rotation) {
    const auto& m = rotation.row;
    const double sine = std::clamp(-m[2].x, -1.0, 1.0);
    Vec3d angles(std::atan2(m[2].y, m[2].z), std::asin(sine), std::atan2(m[1].x, m[0].x));
    // At +-pi/2, x and z rotate about one axis, and only the sum or difference of their angles is determined.
    if (std::abs(sine) > 1 - 1e-12)
        angles = {std::atan2(sine > 0 ? m[0].y : -m[0].y, m[1].y), std::asin(sine), 0};
    return Vec3f(angles);
}

float radians(float degrees) {
    return static_cast<float>(degrees * (pi / 180));
}

float degrees(float angle) {
    const auto found = static_cast<float>(double(angle) * (180 / pi));
    for (const float end : {-INFINITY, INFINITY}) {
        float near = found;
        for (int step = 0; step < 3; ++step, near = std::nextafter(near, end))
            if (radians(near) == angle) return near;
    }
    return found;
}

Rotation rotation_of_degrees(const Vec3f& angles) {
    return rotation_xyz({radians(angles.x), radians(angles.y), radians(angles.z)});
}

Vec3f degrees_xyz(const Rotation& rotation) {
    const auto& m = rotation.row;
    const Vec3d about_one(std::atan2(m[2].y, m[1].y), std::atan2(m[0].z, m[2].z), std::atan2(m[1].x, m[0].x));
    for (int axis = 0; axis < 3; ++axis) {
        Vec3f angles(0.0f);
        angles[axis] = degrees(static_cast<float>(about_one[axis]));
        if (rotation_of_degrees(angles) == rotation) return angles;
    }
    const Vec3f angles = angles_xyz(rotation);
    return {degrees(angles.x), degrees(angles.y), degrees(angles.z)};
}

Rotation as_degrees(const Rotation& rotation) {
    constexpr int enough = 4;  // angles near half a turn may flip to the other end when they are rounded
    Rotation said = rotation_of_degrees(degrees_xyz(rotation));
    for (int i = 0; i < enough; ++i) {
        const Rotation again = rotation_of_degrees(degrees_xyz(said));
        if (again == said) break;
        said = again;
    }
    return said;
}

}  // namespace haarfield
