#include "bridge/povray/lit_points.h"

#include "fields/base/parallel_loop.h"
#include "scenes/camera_frame.h"

#include <algorithm>
#include <cmath>

namespace haarfield {
namespace {

constexpr int most_columns = 64, most_rows = 48;
constexpr float above_surface = 1e-4f;  ///< Start of shadow rays, relative to the distance from the camera.
constexpr float before_place = 0.999f;  ///< End of shadow rays, relative to the distance of the lamp.

/// Returns the irradiance of a point from emitters, with shadows.
Vec3d irradiance(const LitPoints& lit, const LitPoint& point, const EmitterTree& emitters,
                 std::vector<EmitterPatch>& patches) {
    Vec3d sum(0, 0, 0);
    find_patches(emitters, point.position, point.normal, {}, patches);
    for (const EmitterPatch& patch : patches)
        if (lit.sees(point, patch.place)) sum += Vec3d(Vec3f(patch.irradiance));
    return sum;
}

/// Returns the irradiance of a point from lamps, with shadows.
Vec3d irradiance(const LitPoints& lit, const LitPoint& point, std::span<const Lamp> lamps) {
    Vec3d sum(0, 0, 0);
    for (const Lamp& lamp : lamps) {
        const LampLight light = lamp_light(lamp, Vec3d(point.position));
        const double cosine = light.direction.dot(Vec3d(point.normal));
        if (cosine > 0 && light.share > 0 && lit.sees(point, lamp.position))
            sum += Vec3d(Vec3f(lamp.colour)) * (pi * light.share * cosine);
    }
    return sum;
}

}  // namespace

void WorldSurface::add(const Mesh& object, const Placement& placement, std::span<const Rgb> object_albedo) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (std::size_t v = 0; v < object.positions.size(); ++v) {
        mesh.positions.push_back(placement.point_to_world(object.positions[v]));
        mesh.normals.push_back(placement.direction_to_world(object.normals[v]));
    }
    for (const auto& [a, b, c] : object.triangles)
        mesh.triangles.push_back({first + a, first + b, first + c});
    albedo.insert(albedo.end(), object_albedo.begin(), object_albedo.end());
}

LitPoints::LitPoints(const Camera& camera, const WorldSurface& world) : surface_(world.mesh) {
    const CameraFrame frame = camera_frame(camera);
    const double half_height = std::tan(double(camera.vertical_fov) / 2),
                 half_width = half_height * camera.width / camera.height;
    const int columns = std::min(camera.width, most_columns), rows = std::min(camera.height, most_rows);
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) {
            const Vec3f direction(frame.forward +
                                  frame.right * (half_width * (2 * (column + 0.5) / columns - 1)) +
                                  frame.up * (half_height * (1 - 2 * (row + 0.5) / rows)));
            const std::optional<FirstSurface::Hit> hit = surface_(camera.position, direction);
            if (!hit) continue;
            const auto& corners = world.mesh.triangles[hit->triangle];
            const std::array<float, 3> weights{1 - hit->u - hit->v, hit->u, hit->v};
            LitPoint point;
            point.position = Vec3f(0, 0, 0);
            Vec3f normal(0, 0, 0);
            for (std::size_t k = 0; k < 3; ++k) {
                point.position += world.mesh.positions[corners[k]] * weights[k];
                normal += world.mesh.normals[corners[k]] * weights[k];
                point.albedo += world.albedo[corners[k]] * weights[k];
            }
            if (!(normal.length() > 0)) continue;
            point.normal = normal.normalized() * (normal.dot(direction) > 0 ? -1.0f : 1.0f);
            point.position += point.normal * (above_surface * (point.position - camera.position).length());
            points_.push_back(point);
        }
}

bool LitPoints::sees(const LitPoint& point, const Vec3f& place) const {
    return !surface_.is_met(point.position, (place - point.position) * before_place);
}

double common_lamp_error(const LampSets& sets) {
    const EmitterTree tree = emitter_tree(sets.emitters);
    const std::span<const LitPoint> points = sets.lit.points();
    if (tree.empty() || points.empty()) return 0;
    std::vector<double> products(points.size());
    const Result<Done> done =
        parallel_loop({points.size(), 16},
                      [&]() -> LoopBody {
                          return [&, patches = std::vector<EmitterPatch>()](std::size_t k) mutable {
                              const LitPoint& point = points[k];
                              const Vec3d exact = irradiance(sets.lit, point, tree, patches),
                                          first = irradiance(sets.lit, point, sets.lamps[0]) - exact,
                                          second = irradiance(sets.lit, point, sets.lamps[1]) - exact,
                                          albedo = Vec3d(Vec3f(point.albedo)) / pi;
                              products[k] = (albedo * first).dot(albedo * second) / 3;
                          };
                      },
                      "", {});
    (void)done;  // nothing interrupts it
    double sum = 0;
    for (const double product : products) sum += product;
    return std::sqrt(std::max(0.0, sum) / double(points.size()));
}

}  // namespace haarfield
