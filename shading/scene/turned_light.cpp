#include "shading/scene/turned_light.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "shading/scene/lighting.h"

namespace haarfield {
namespace {

constexpr float bright_above = 8;  ///< Multiple of the mean.

/// Face, u and v in [-1, 1] where a direction intersects the cube: cubemap_point in single precision.
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

/// A rotated face: directions are linear in u and v.
struct TurnedFace {
    Vec3f middle, right, down;

    TurnedFace(const Rotation& rotation, int face) {
        const auto turned = [&](double u, double v) {
            return rotation(cubemap_direction<Vec3d>(face, u, v));
        };
        middle = Vec3f(turned(0, 0));
        right = Vec3f(turned(1, 0) - turned(0, 0));
        down = Vec3f(turned(0, 1) - turned(0, 0));
    }
    /// Returns the direction to point i of a grid in a texel, with `places` points along its edge.
    Vec3f direction(int column, int row, int i, int places, int size) const {
        const auto coordinate = [&](int texel, int place) {
            return static_cast<float>(2 * (places * texel + place) + 1) / static_cast<float>(places * size) -
                   1;
        };
        return middle + right * coordinate(column, i % places) + down * coordinate(row, i / places);
    }
};

Rgb interpolated(const TurnableLight& light, const Vec3f& direction) {
    const int size = 2 * light.face_size;
    const Place at = place_of(direction);
    // Beyond the outermost texel centres, a face's values are extended.
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

/// Returns the indices of the four quarters of the lighting's texel.
std::array<std::size_t, 4> quarters(int face_size, int column, int row) {
    const auto size = static_cast<std::size_t>(2 * face_size),
               first = static_cast<std::size_t>(2 * row) * size + static_cast<std::size_t>(2 * column);
    return {first, first + 1, first + size, first + size + 1};
}

void add_even_part(const TurnableLight& light, const Rotation& rotation, std::vector<Rgb>& texels) {
    constexpr int places = 2;
    const int size = light.face_size;
    const Rotation inverse = rotation.inverse();
    tbb::parallel_for(0, cubemap_faces * size, [&](int line) {
        const TurnedFace face(inverse, line / size);
        const int row = line % size;
        for (int column = 0; column < size; ++column) {
            Rgb sum(0.0f);
            for (int i = 0; i < places * places; ++i)
                sum += interpolated(light, face.direction(column, row, i, places, size));
            float solid_angle = 0;
            for (const std::size_t quarter : quarters(size, column, row))
                solid_angle += light.solid_angles[quarter] / 4;
            texels[std::size_t(line * size + column)] += sum * (solid_angle / (places * places));
        }
    });
}

void add_bright_texels(const TurnableLight& light, const Rotation& rotation, std::vector<Rgb>& texels) {
    constexpr int places = 4;
    const int size = light.face_size, from_size = 2 * size;
    for (const auto& [texel, all] : light.bright) {
        const int from = static_cast<int>(texel), line = from / from_size;
        const TurnedFace face(rotation, line / from_size);
        for (int i = 0; i < places * places; ++i) {
            const Place at =
                place_of(face.direction(from % from_size, line % from_size, i, places, from_size));
            const auto index = [size](float u) {
                return std::clamp(static_cast<int>((u + 1) * 0.5f * static_cast<float>(size)), 0, size - 1);
            };
            texels[std::size_t((at.face * size + index(at.v)) * size + index(at.u))] +=
                all / (places * places);
        }
    }
}

/// Computes the lighting for the identity rotation.
std::vector<Rgb> unturned_lighting_texels(const TurnableLight& light) {
    const int size = light.face_size;
    const std::size_t texels_a_face = light.solid_angles.size();
    std::vector<Rgb> texels;
    for (std::size_t face = 0; face < cubemap_faces; ++face)
        for (int row = 0; row < size; ++row)
            for (int column = 0; column < size; ++column) {
                Rgb& sum = texels.emplace_back(0.0f);
                for (const std::size_t quarter : quarters(size, column, row))
                    sum += light.radiance[face * texels_a_face + quarter] * (light.solid_angles[quarter] / 4);
            }
    for (const auto& [texel, all] : light.bright) {
        const auto column = static_cast<int>(texel) % (2 * size), line = static_cast<int>(texel) / (2 * size);
        texels[std::size_t(line / 2 * size + column / 2)] += all;
    }
    return texels;
}

}  // namespace

TurnableLight turnable_light(const LatLongImage& environment, int face_size, const std::stop_token& stop) {
    const int size = 2 * face_size;
    TurnableLight light{face_size, lighting_texels(environment, size, stop), {}, {}};
    const auto peak = [](const Rgb& colour) { return std::max({colour.x, colour.y, colour.z}); };
    double sum = 0;
    for (const Rgb& texel : light.radiance) sum += double(peak(texel));
    const float limit = bright_above * static_cast<float>(sum / (4 * pi * size * size));
    for (int i = 0; i < size * size; ++i)
        light.solid_angles.push_back(
            static_cast<float>(texel_solid_angle(i % size, i / size, size) * size * size));
    for (std::size_t i = 0; i < light.radiance.size(); ++i) {
        const float solid_angle = light.solid_angles[i % light.solid_angles.size()];
        Rgb& radiance = light.radiance[i];
        const Rgb whole = radiance;
        radiance /= solid_angle;
        if (peak(radiance) <= limit) continue;
        radiance *= limit / peak(radiance);
        // Texels contain solid angle times their number, and the lighting has a fourth of the texels.
        light.bright.push_back({static_cast<std::uint32_t>(i), (whole - radiance * solid_angle) / 4});
    }
    return light;
}

std::vector<Rgb> turned_lighting_texels(const TurnableLight& light, const Rotation& rotation) {
    if (is_identity(rotation)) return unturned_lighting_texels(light);
    std::vector<Rgb> texels(std::size_t(cubemap_faces * light.face_size) * std::size_t(light.face_size),
                            Rgb(0.0f));
    add_even_part(light, rotation, texels);
    add_bright_texels(light, rotation, texels);
    return texels;
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

Environment turned_environment(const Environment& environment, const Rotation& rotation,
                               const std::stop_token& stop) {
    Environment turned{turned_environment(environment.image, rotation, stop), environment.suns};
    if (!environment.backdrop.pixels.empty())
        turned.backdrop = turned_environment(environment.backdrop, rotation, stop);
    for (SunDisc& sun : turned.suns) sun.direction = rotation(sun.direction);
    return turned;
}

}  // namespace haarfield
