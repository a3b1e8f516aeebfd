#include "shading/bounces/lit_surface.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

#include "shading/bounces/cosine_directions.h"
#include "shading/bounces/gathering_directions.h"

namespace haarfield {
namespace {

const Mesh& mesh_of(const ShadedScene& scene, std::size_t instance) {
    return *scene.entities[scene.instances[instance].entity].mesh;
}

std::array<Rgb, 3> corner_values(const Mesh& mesh, std::uint32_t triangle, const std::vector<Rgb>& values) {
    const auto& [a, b, c] = mesh.triangles[triangle];
    return {values[a], values[b], values[c]};
}

Rgb between(const std::array<Rgb, 3>& values, const std::array<float, 3>& weights) {
    return values[0] * weights[0] + values[1] * weights[1] + values[2] * weights[2];
}

/// Returns a normal whose length is twice the area of the triangle, in the mesh's frame.
Vec3f double_area(const Mesh& mesh, std::uint32_t triangle) {
    const auto& [a, b, c] = mesh.triangles[triangle];
    return (mesh.positions[b] - mesh.positions[a]).cross(mesh.positions[c] - mesh.positions[a]);
}

/// Returns the area of a triangle in the world. [m^2]
double area_of(const ShadedScene& scene, std::size_t instance, std::uint32_t triangle) {
    const double scale = scene.instances[instance].placement.scale;
    return 0.5 * double(double_area(mesh_of(scene, instance), triangle).length()) * scale * scale;
}

Rgb mean(const std::array<Rgb, 3>& values) {
    return (values[0] + values[1] + values[2]) * (1 / 3.0f);
}

/// Returns the difference of direct light in a cell of a divided triangle.
Rgb difference_at(const DirectDetail& detail, std::size_t instance, std::size_t triangle, std::size_t cell) {
    return detail.differences[std::size_t(detail.places[instance][triangle]) * DirectDetail::cells + cell];
}

/// Returns the radiance in the centre of a cell.
///
/// radiance  of the triangle's corners.
Rgb centre_of(const DirectDetail& detail, std::size_t instance, std::size_t triangle, std::size_t cell,
              const std::array<Rgb, 3>& radiance) {
    return between(radiance, DirectDetail::centre(cell)) + difference_at(detail, instance, triangle, cell);
}

double brightness(const Rgb& radiance) {
    return std::max(0.0, double(luminance(radiance)));
}

/// A triangle or a cell of one, as a source of light.
struct Element {
    InstanceTriangle of;
    std::array<Vec2f, 3> corners;  ///< Weights of the triangle's second and third corners.
    double brightness = 0;         ///< Mean luminance. [W/(m^2 sr)]
    double light = 0;              ///< Luminance times area. [W/sr]
};

/// Returns the triangles, or their cells, along a curve through the scene.
std::vector<Element> elements(const ShadedScene& scene, const SceneColours& radiance,
                              const DirectDetail& detail) {
    std::vector<InstanceTriangle> triangles;
    std::vector<Vec3f> centres;
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
        const Mesh& mesh = mesh_of(scene, i);
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            const auto& [a, b, c] = mesh.triangles[t];
            triangles.push_back({i, t});
            centres.push_back(scene.instances[i].placement.point_to_world(
                (mesh.positions[a] + mesh.positions[b] + mesh.positions[c]) * (1 / 3.0f)));
        }
    }
    std::vector<Element> result;
    for (const std::uint32_t k : spatial_order(centres)) {
        const auto [i, t] = triangles[k];
        const std::array<Rgb, 3> corners = corner_values(mesh_of(scene, i), t, radiance[i]);
        const double area = area_of(scene, i, t);
        if (detail.places[i][t] < 0) {
            const double bright = brightness(mean(corners));
            result.push_back({{i, t}, {Vec2f(0, 0), Vec2f(1, 0), Vec2f(0, 1)}, bright, bright * area});
            continue;
        }
        for (std::size_t cell = 0; cell < DirectDetail::cells; ++cell) {
            const double bright = brightness(centre_of(detail, i, t, cell, corners));
            result.push_back(
                {{i, t}, DirectDetail::corners(cell), bright, bright * area / double(DirectDetail::cells)});
        }
    }
    return result;
}

/// Returns the point of an element for a point of the unit square, uniformly by area.
SurfaceHit point_of(const Element& element, const Vec2f& square) {
    const float root = std::sqrt(square.x), b = root * (1 - square.y), c = root * square.y;
    SurfaceHit hit{element.of.instance, element.of.triangle};
    const std::array<float, 3> weights{1 - root, b, c};
    for (std::size_t k = 0; k < 3; ++k) {
        hit.u += weights[k] * element.corners[k].x;
        hit.v += weights[k] * element.corners[k].y;
    }
    return hit;
}

}  // namespace

std::size_t DirectDetail::cell_at(float u, float v) {
    const float x = std::clamp(u, 0.0f, 1.0f) * float(steps), y = std::clamp(v, 0.0f, 1.0f) * float(steps);
    const std::size_t row = std::min(steps - 1, std::size_t(y)),
                      column = std::min(steps - 1 - row, std::size_t(x));
    const bool is_turned = x - float(column) + y - float(row) > 1 && column + row + 1 < steps;
    return row * (2 * steps - row) + 2 * column + (is_turned ? 1 : 0);
}

std::array<Vec2f, 3> DirectDetail::corners(std::size_t cell) {
    assert(cell < cells);
    std::size_t row = 0;
    while ((row + 1) * (2 * steps - row - 1) <= cell) ++row;
    const std::size_t place = cell - row * (2 * steps - row);
    const Vec2f low(float(place / 2), float(row));
    const float size = 1 / float(steps);
    if (place % 2 == 0) return {low * size, (low + Vec2f(1, 0)) * size, (low + Vec2f(0, 1)) * size};
    return {(low + Vec2f(1, 0)) * size, (low + Vec2f(1, 1)) * size, (low + Vec2f(0, 1)) * size};
}

std::array<float, 3> DirectDetail::centre(std::size_t cell) {
    const std::array<Vec2f, 3> around = corners(cell);
    const Vec2f centre = (around[0] + around[1] + around[2]) / 3;
    return {1 - centre.x - centre.y, centre.x, centre.y};
}

std::vector<InstanceTriangle> uneven_triangles(const ShadedScene& scene, const SceneColours& direct,
                                               double share, std::size_t most) {
    struct Uneven {
        double product;
        InstanceTriangle triangle;
    };
    std::vector<Uneven> found;
    double whole = 0;
    for (std::uint32_t i = 0; i < scene.instances.size(); ++i) {
        const Mesh& mesh = mesh_of(scene, i);
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            const std::array<Rgb, 3> corners = corner_values(mesh, t, direct[i]);
            const auto [low, high] =
                std::minmax({luminance(corners[0]), luminance(corners[1]), luminance(corners[2])});
            const double area = area_of(scene, i, t);
            whole += area * brightness(mean(corners));
            if (high > low) found.push_back({area * double(high - low), {i, t}});
        }
    }
    std::erase_if(found, [&](const Uneven& uneven) { return uneven.product < share * whole; });
    std::ranges::stable_sort(found, std::greater(), &Uneven::product);
    if (found.size() > most) found.resize(most);
    std::vector<InstanceTriangle> result;
    for (const Uneven& uneven : found) result.push_back(uneven.triangle);
    std::ranges::sort(result, {},
                      [](const InstanceTriangle& t) { return std::pair(t.instance, t.triangle); });
    return result;
}

void average_detail(const ShadedScene& scene, const DirectDetail& detail, SceneColours& direct) {
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const Mesh& mesh = mesh_of(scene, i);
        std::vector<Rgb> added(direct[i].size(), Rgb(0.0f));
        std::vector<float> areas(direct[i].size(), 0.0f);
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            const auto area = float(area_of(scene, i, t));
            const std::array<std::uint32_t, 3>& corners = mesh.triangles[t];
            for (const std::uint32_t v : corners) areas[v] += area / 3;
            if (detail.places[i][t] < 0) continue;
            const std::array<Rgb, 3> values = corner_values(mesh, t, direct[i]);
            const float cell_area = area / float(DirectDetail::cells);
            for (std::size_t cell = 0; cell < DirectDetail::cells; ++cell) {
                const Rgb light = centre_of(detail, i, t, cell, values) * cell_area;
                const std::array<float, 3> weights = DirectDetail::centre(cell);
                for (std::size_t c = 0; c < 3; ++c) added[corners[c]] += light * weights[c];
            }
            for (std::size_t c = 0; c < 3; ++c) added[corners[c]] -= values[c] * (area / 3);
        }
        for (std::size_t v = 0; v < added.size(); ++v)
            if (areas[v] > 0) {
                direct[i][v] += added[v] / areas[v];
                for (int c = 0; c < 3; ++c) direct[i][v][c] = std::max(0.0f, direct[i][v][c]);
            }
    }
}

LitSurface::LitSurface(const ShadedScene& scene, const SceneColours& radiance, DirectDetail detail)
    : detail_(std::move(detail)) {
    const std::vector<Element> sources = elements(scene, radiance, detail_);
    for (const Element& element : sources) whole_ += element.light;
    for (int number = least_gathering_rays; number <= most_gathering_rays; number *= 2) {
        std::vector<BrightPoint>& points = points_.emplace_back();
        double before = 0;
        auto element = sources.begin();
        for (int k = 0; whole_ > 0 && k < number; ++k) {
            const double wanted = (double(k) + 0.5) / double(number) * whole_;
            while (std::next(element) != sources.end() && before + element->light <= wanted)
                before += (element++)->light;
            if (!(element->light > 0)) continue;  // By rounding, at the end.
            const SurfaceHit hit = point_of(*element, sobol_point(static_cast<std::uint32_t>(k)));
            const Mesh& mesh = mesh_of(scene, hit.instance);
            const Placement& placement = scene.instances[hit.instance].placement;
            const auto& corners = mesh.triangles[hit.triangle];
            const std::array<float, 3> weights = hit.weights();
            Vec3f position(0.0f);
            for (std::size_t c = 0; c < 3; ++c) position += mesh.positions[corners[c]] * weights[c];
            points.push_back({placement.point_to_world(position),
                              placement.direction_to_world(double_area(mesh, hit.triangle).normalized()),
                              radiance_at(scene, radiance, hit), float(element->brightness / whole_)});
        }
    }
}

Rgb LitSurface::radiance_at(const ShadedScene& scene, const SceneColours& radiance,
                            const SurfaceHit& hit) const {
    const Rgb smooth = between(
        corner_values(mesh_of(scene, hit.instance), hit.triangle, radiance[hit.instance]), hit.weights());
    if (detail_.places[hit.instance][hit.triangle] < 0) return smooth;
    const Rgb rough =
        smooth + difference_at(detail_, hit.instance, hit.triangle, DirectDetail::cell_at(hit.u, hit.v));
    return Rgb(std::max(0.0f, rough.x), std::max(0.0f, rough.y), std::max(0.0f, rough.z));
}

float LitSurface::density_at(const ShadedScene& scene, const SceneColours& radiance,
                             const SurfaceHit& hit) const {
    if (!(whole_ > 0)) return 0;
    const std::array<Rgb, 3> corners =
        corner_values(mesh_of(scene, hit.instance), hit.triangle, radiance[hit.instance]);
    const Rgb bright =
        detail_.places[hit.instance][hit.triangle] < 0
            ? mean(corners)
            : centre_of(detail_, hit.instance, hit.triangle, DirectDetail::cell_at(hit.u, hit.v), corners);
    return float(brightness(bright) / whole_);
}

std::span<const LitSurface::BrightPoint> LitSurface::points(int number) const {
    assert(number >= least_gathering_rays && number <= most_gathering_rays);
    return points_[static_cast<std::size_t>(std::countr_zero(static_cast<unsigned>(number)) -
                                            std::countr_zero(unsigned(least_gathering_rays)))];
}

}  // namespace haarfield
