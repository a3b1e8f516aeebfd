#include "shading/turned_light.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "shading/lighting.h"

namespace haarfield {
namespace {

constexpr int places = 4;  ///< Along an edge of a texel.

/// Face, u and v in [-1, 1] where a direction pierces the cube: cubemap_point in single precision.
struct Place {
    int face;
    float u, v;
};

Place place_of(const Vec3f& d) {
    const float x = std::abs(d.x), y = std::abs(d.y), z = std::abs(d.z);
    if (x >= y && x >= z) return d.x > 0 ? Place{0, d.z / x, -d.y / x} : Place{1, -d.z / x, -d.y / x};
    if (y >= z) return d.y > 0 ? Place{2, d.x / y, -d.z / y} : Place{3, d.x / y, d.z / y};
    return d.z > 0 ? Place{4, -d.x / z, -d.y / z} : Place{5, d.x / z, -d.y / z};
}

Rgb interpolated(const TurnableLight& light, const Vec3f& direction) {
    const int size = 2 * light.face_size;
    const Place at = place_of(direction);
    // Beyond the outermost centres of a face its own texels go on.
    const auto coordinate = [size](float u) {
        return std::clamp((u + 1) * 0.5f * static_cast<float>(size) - 0.5f, 0.0f,
                          static_cast<float>(size - 1));
    };
    const float x = coordinate(at.u), y = coordinate(at.v);
    const int column = std::min(static_cast<int>(x), size - 2), row = std::min(static_cast<int>(y), size - 2);
    const float right = x - static_cast<float>(column), down = y - static_cast<float>(row);
    const Rgb* top = &light.radiance[std::size_t((at.face * size + row) * size + column)];
    const Rgb* bottom = top + size;
    return (top[0] * (1 - right) + top[1] * right) * (1 - down) +
           (bottom[0] * (1 - right) + bottom[1] * right) * down;
}

}  // namespace

TurnableLight turnable_light(const LatLongImage& environment, int face_size, const std::stop_token& stop) {
    const int size = 2 * face_size;
    TurnableLight light{face_size, lighting_texels(environment, size, stop)};
    for (std::size_t i = 0; i < light.radiance.size(); ++i) {
        const int column = static_cast<int>(i) % size, row = static_cast<int>(i) / size % size;
        light.radiance[i] /= static_cast<float>(texel_solid_angle(column, row, size) * size * size);
    }
    return light;
}

std::vector<Rgb> turned_lighting_texels(const TurnableLight& light, const Rotation& rotation) {
    const int size = light.face_size;
    const Rotation inverse = rotation.inverse();
    std::vector<Rgb> texels(std::size_t(cubemap_faces * size) * std::size_t(size));
    tbb::parallel_for(0, cubemap_faces * size, [&](int line) {
        const int face = line / size, row = line % size;
        const auto from = [&](float u, float v) {
            return inverse(cubemap_direction<Vec3d>(face, double(u), double(v)));
        };
        // Directions are linear in u and v.
        const Vec3f origin(from(0, 0)), right(from(1, 0) - from(0, 0)), down(from(0, 1) - from(0, 0));
        const float step = 2.0f / static_cast<float>(places * size);
        for (int column = 0; column < size; ++column) {
            Rgb sum(0.0f);
            for (int i = 0; i < places * places; ++i) {
                const float u = (static_cast<float>(places * column + i % places) + 0.5f) * step - 1,
                            v = (static_cast<float>(places * row + i / places) + 0.5f) * step - 1;
                const float r = 1 + u * u + v * v;  // the solid angle of du dv is r^-3/2
                sum += interpolated(light, origin + right * u + down * v) / (r * std::sqrt(r));
            }
            texels[std::size_t(line * size + column)] = sum * (4.0f / (places * places));
        }
    });
    return texels;
}

Rgb radiance_from(const LatLongImage& image, const Vec3d& direction) {
    double x = 0, y = 0;
    lat_long_point(direction.normalized(), x, y);
    const double column = x * image.width - 0.5,
                 row = std::clamp(y * image.height - 0.5, 0.0, image.height - 1.0);
    const int top = std::min(static_cast<int>(row), image.height - 2),
              left = static_cast<int>(std::floor(column));
    const auto right_share = static_cast<float>(column - left), lower_share = static_cast<float>(row - top);
    const auto pixel = [&](int r, int c) -> const Rgb& {
        return image.pixels[std::size_t(r * image.width + (c + image.width) % image.width)];
    };
    const auto along_row = [&](int r) {
        return pixel(r, left) * (1 - right_share) + pixel(r, left + 1) * right_share;
    };
    return along_row(top) * (1 - lower_share) + along_row(top + 1) * lower_share;
}

LatLongImage turned_environment(const LatLongImage& image, const Rotation& rotation,
                                const std::stop_token& stop) {
    if (rotation.row[1] == Vec3d(0, 1, 0))
        return turned_environment(image, std::atan2(rotation.row[0].z, rotation.row[0].x), 0);
    const Rotation inverse = rotation.inverse();
    LatLongImage turned = image;
    tbb::parallel_for(0, image.height, [&](int row) {
        for (int column = 0; column < image.width && !stop.stop_requested(); ++column)
            turned.pixels[std::size_t(row * image.width + column)] = radiance_from(
                image, inverse(lat_long_direction((column + 0.5) / image.width, (row + 0.5) / image.height)));
    });
    return turned;
}

}  // namespace haarfield
