#include "fields/wavelets/cubemap.h"

#include <algorithm>
#include <cmath>

namespace haarfield {

CubemapPoint cubemap_point(const Vec3d& d) {
    const double ax = std::abs(d.x), ay = std::abs(d.y), az = std::abs(d.z);
    // The inverse of cubemap_direction, face by face.
    if (ax >= ay && ax >= az) {
        if (d.x > 0) return {0, d.z / ax, -d.y / ax};
        return {1, -d.z / ax, -d.y / ax};
    }
    if (ay >= az) {
        if (d.y > 0) return {2, d.x / ay, -d.z / ay};
        return {3, d.x / ay, d.z / ay};
    }
    if (d.z > 0) return {4, -d.x / az, -d.y / az};
    return {5, d.x / az, -d.y / az};
}

Vec3f texel_direction(int face, int column, int row, int size) {
    const double u = (2.0 * column + 1.0) / size - 1.0, v = (2.0 * row + 1.0) / size - 1.0;
    return Vec3f(cubemap_direction<Vec3d>(face, u, v).normalized());
}

std::vector<Vec3f> texel_directions(int size) {
    std::vector<Vec3f> directions;
    for (int face = 0; face < cubemap_faces; ++face)
        for (int row = 0; row < size; ++row)
            for (int column = 0; column < size; ++column)
                directions.push_back(texel_direction(face, column, row, size));
    return directions;
}

namespace {

/// Returns the signed solid angle of the rectangle from the face's centre (0,0) to (u,v). [sr]
double corner_solid_angle(double u, double v) {
    return std::atan2(u * v, std::sqrt(1 + u * u + v * v));
}

}  // namespace

double texel_solid_angle(int column, int row, int size) {
    const double u0 = 2.0 * column / size - 1.0, u1 = 2.0 * (column + 1) / size - 1.0;
    const double v0 = 2.0 * row / size - 1.0, v1 = 2.0 * (row + 1) / size - 1.0;
    return corner_solid_angle(u1, v1) - corner_solid_angle(u0, v1) - corner_solid_angle(u1, v0) +
           corner_solid_angle(u0, v0);
}

Vec3d lat_long_direction(double x, double y) {
    const double longitude = pi * (1 - 2 * x), latitude = pi * (0.5 - y);
    return {std::sin(longitude) * std::cos(latitude), std::sin(latitude),
            std::cos(longitude) * std::cos(latitude)};
}

void lat_long_point(const Vec3d& direction, double& x, double& y) {
    const double longitude = std::atan2(direction.x, direction.z);
    x = 0.5 * (1 - longitude / pi);
    if (x >= 1) x -= 1;
    const double sine = direction.y / direction.length();
    y = 0.5 - std::asin(std::clamp(sine, -1.0, 1.0)) / pi;
}

}  // namespace haarfield
