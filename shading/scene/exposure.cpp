#include "shading/scene/exposure.h"

#include "fields/base/spiral.h"
#include "shading/scene/light_sources.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace haarfield {

namespace {

constexpr double white = 0.8;  // albedo
constexpr int columns = 64, rows = 32;
constexpr std::size_t normals = 1024;

}  // namespace

std::vector<ExposedLight> gathered_light(const Environment& environment) {
    const LatLongImage& image = environment.image;
    std::vector<Vec3d> cells(std::size_t(columns * rows), Vec3d(0, 0, 0));  // Irradiance * direction.
    std::vector<Vec3d> meridians;  // Horizontal directions of the columns.
    for (int column = 0; column < image.width; ++column)
        meridians.push_back(lat_long_direction((column + 0.5) / image.width, 0.5));
    tbb::parallel_for(0, rows, [&](int cell_row) {
        for (int row = 0; row < image.height; ++row) {
            if (std::int64_t(row) * rows / image.height != cell_row) continue;
            const double solid_angle = lat_long_pixel_solid_angle(row, image.width, image.height),
                         latitude = pi * (0.5 - (row + 0.5) / image.height), cosine = std::cos(latitude),
                         sine = std::sin(latitude);
            for (int column = 0; column < image.width; ++column) {
                const Rgb& radiance =
                    image.pixels[std::size_t(row) * std::size_t(image.width) + std::size_t(column)];
                const Vec3d& meridian = meridians[std::size_t(column)];
                cells[std::size_t(cell_row) * columns +
                      std::size_t(std::int64_t(column) * columns / image.width)] +=
                    Vec3d(meridian.x * cosine, sine, meridian.z * cosine) *
                    (double(luminance(radiance)) * solid_angle);
            }
        }
    });
    std::vector<ExposedLight> light;
    for (const Vec3d& cell : cells)
        if (cell.length() > 0) light.push_back({cell.normalized(), cell.length()});
    for (const SunDisc& sun : environment.suns)
        light.push_back({Vec3d(sun.direction), double(luminance(sun.irradiance))});
    return light;
}

float automatic_exposure(const Environment& environment) {
    return automatic_exposure(environment, {});
}

float automatic_exposure(const Environment& environment, std::span<const ExposedLight> local) {
    return automatic_exposure(gathered_light(environment), local);
}

float automatic_exposure(std::span<const ExposedLight> environment, std::span<const ExposedLight> local) {
    constexpr double brightest = pi / white, least = brightest / 16;  // irradiance
    double gain = INFINITY;
    for (std::size_t i = 0; i < normals; ++i) {
        const Vec3d upright = spiral_direction(i, 1 - (2 * double(i) + 1) / normals),
                    normal(upright.x, upright.z, upright.y);
        double distant = 0, near = 0;
        for (const ExposedLight& light : environment)
            distant += light.irradiance * std::max(0.0, normal.dot(light.direction));
        for (const ExposedLight& lamp : local)
            near += lamp.irradiance * std::max(0.0, normal.dot(lamp.direction));
        if (distant > 0) gain = std::min(gain, std::max(brightest - near, least) / distant);
    }
    if (!std::isfinite(gain)) return 0;
    return static_cast<float>(std::clamp(std::log2(gain), -60.0, 60.0));
}

}  // namespace haarfield
