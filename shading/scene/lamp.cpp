#include "shading/scene/lamp.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace haarfield {
namespace {

/// POV-Ray's cubic spline: 0 up to low, 1 from high, smooth in between.
double smooth_step(double low, double high, double at) {
    if (at >= high) return 1;
    if (at <= low) return 0;
    const double t = (at - low) / (high - low);
    return t * t * (3 - 2 * t);
}

double faded(const Lamp& lamp, double distance) {
    if (!(lamp.fade_distance > 0)) return 1;
    const double ratio = distance / double(lamp.fade_distance);
    return 2 / (1 + (lamp.fade_power == 2 ? ratio * ratio : std::pow(ratio, double(lamp.fade_power))));
}

double power(double base, double exponent) {
    return exponent == 0 ? 1 : std::pow(base, exponent);
}

/// Returns the weights of the positions along one axis of a grid.
std::vector<double> axis_weights(std::size_t count) {
    struct Range {
        std::size_t first, last;
        double weight;
    };
    std::vector<double> weights(count, 0.0);
    std::vector<Range> left{{0, count - 1, 1}};
    while (!left.empty()) {
        const Range range = left.back();
        left.pop_back();
        if (range.first == range.last) {
            weights[range.first] += range.weight;
            continue;
        }
        const std::size_t sum = range.first + range.last;
        left.push_back({range.first, sum / 2, range.weight / 2});
        left.push_back({(sum + 1) / 2, range.last, range.weight / 2});
    }
    return weights;
}

double axis_place(std::size_t index, std::size_t count) {
    return count > 1 ? double(index) / double(count - 1) - 0.5 : 0;
}

}  // namespace

LampLight lamp_light(const Lamp& lamp, const Vec3d& point) {
    const Vec3d to_lamp = Vec3d(lamp.position) - point;
    if (lamp.kind == LampKind::point) {
        const double distance = to_lamp.length();
        if (!(distance > 0)) return {Vec3d(0, 1, 0), 0, 0};
        return {to_lamp / distance, distance, faded(lamp, distance)};
    }
    const Vec3d axis = (Vec3d(lamp.target) - Vec3d(lamp.position)).normalized();
    const double depth = -to_lamp.dot(axis);
    if (lamp.kind == LampKind::spot) {
        const double distance = to_lamp.length();
        if (!(depth > 0)) return {-axis, distance, 0};
        const double cosine = depth / distance, share = power(cosine, double(lamp.tightness)) *
                                                        smooth_step(std::cos(double(lamp.falloff)),
                                                                    std::cos(double(lamp.radius)), cosine);
        return {to_lamp / distance, distance, share > 0 ? share * faded(lamp, distance) : 0};
    }
    // Parallel light also lights points behind the lamp's position, where nothing occludes it.
    LampLight light{-axis, std::max(depth, 0.0), 0};
    if (lamp.kind == LampKind::parallel) {
        light.share = faded(lamp, std::abs(depth));
        return light;
    }
    if (!(depth > 0) || !(lamp.falloff > 0)) return light;
    const double from_axis = std::sqrt(std::max(0.0, to_lamp.length2() - depth * depth)),
                 inside = 1 - from_axis / double(lamp.falloff);
    if (!(inside > 0)) return light;
    light.share = power(inside, double(lamp.tightness)) * faded(lamp, depth);
    if (from_axis > double(lamp.radius))
        light.share *= smooth_step(0, 1 - double(lamp.radius) / double(lamp.falloff), inside);
    return light;
}

std::vector<LampPlace> lamp_places(const std::optional<LampArea>& area) {
    if (!area) return {{0, 0, 1}};
    assert(area->columns >= 1 && area->rows >= 1);
    const std::vector<double> columns = axis_weights(area->columns), rows = axis_weights(area->rows);
    std::vector<LampPlace> places;
    for (std::size_t row = 0; row < rows.size(); ++row)
        for (std::size_t column = 0; column < columns.size(); ++column) {
            double across = axis_place(column, columns.size()), along = axis_place(row, rows.size());
            const double length = std::hypot(across, along);
            if (area->circular && length > 0) {
                const double bent = std::max(std::abs(across), std::abs(along)) / length;
                across *= bent;
                along *= bent;
            }
            places.push_back({across, along, columns[column] * rows[row]});
        }
    return places;
}

std::vector<PlacedLamp> placed_lamps(std::span<const Lamp> lamps) {
    std::vector<PlacedLamp> placed;
    for (const Lamp& lamp : lamps)
        if (lamp.colour != Rgb(0.0f)) placed.push_back({lamp, lamp_places(lamp.area)});
    return placed;
}

Vec3d lamp_place(const Lamp& lamp, const LampPlace& place, const Vec3d& direction) {
    const Vec3d middle(lamp.position);
    if (!lamp.area) return middle;
    Vec3d across(lamp.area->across), along(lamp.area->along);
    if (lamp.area->orient) {
        // POV-Ray's choice of the horizontal direction.
        const Vec3d other = std::abs(std::abs(direction.z) - 1) < 0.01 ? Vec3d(0, 1, 0) : Vec3d(0, 0, 1);
        const Vec3d level = direction.cross(other).normalized();
        along = direction.cross(level).normalized() * along.length();
        across = level * across.length();
    }
    return middle + across * place.across + along * place.along;
}

}  // namespace haarfield
