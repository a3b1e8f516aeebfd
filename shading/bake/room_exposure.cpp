#include "shading/bake/room_exposure.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "fields/base/embree_rays.h"
#include "fields/base/spiral.h"
#include "shading/bake/source_choice.h"
#include "shading/bounces/cosine_directions.h"
#include "shading/scene/light_sources.h"
#include "shading/scene/scene_light.h"
#include "shading/visibility/instanced_triangles.h"

namespace haarfield {
namespace {

constexpr double white = 0.8;  // albedo
constexpr std::uint32_t paths = 2048;
constexpr int reflections = 32;

double largest(const Rgb& colour) {
    return double(std::max({colour.x, colour.y, colour.z}));
}

/// Returns the mean albedo of an entity's surfaces, by area.
Rgb mean_albedo(const ShadedEntity& entity) {
    // The mean of equal values would depend on the mesh by rounding.
    if (entity.materials.size() == 1 && entity.tints.empty()) return entity.materials[0].diffuse;
    const Mesh& mesh = *entity.mesh;
    Vec3d sum(0.0);
    double areas = 0;
    for (const auto& corners : mesh.triangles) {
        const Vec3f &a = mesh.positions[corners[0]], &b = mesh.positions[corners[1]],
                    &c = mesh.positions[corners[2]];
        const double area = double((b - a).cross(c - a).length());
        for (const std::uint32_t v : corners) {
            const Rgb albedo = entity.materials[mesh.vertex_materials[v]].diffuse;
            sum += Vec3d(entity.tints.empty() ? albedo : albedo * entity.tints[v]) * (area / 3);
        }
        areas += area;
    }
    return areas > 0 ? Rgb(sum / areas) : Rgb(0.0f);
}

class Room {
public:
    explicit Room(const ShadedScene& scene) : scene_(scene), emitters_(scene_emitters(scene)) {
        for (const ShadedEntity& entity : scene.entities) {
            const Occluder& original = entity.occlusion->original();
            triangles_.add_entity(original.positions(), original.triangles());
        }
        triangles_.place(scene);
    }

    bool is_open() const {
        constexpr std::size_t directions = 1024, fewest_open = directions / 4;
        std::size_t open = 0;
        for (std::size_t i = 0; i < directions; ++i) {
            const Vec3f direction(spiral_direction(i, 1 - (2 * double(i) + 1) / directions));
            open += !meets_any(triangles_.scene(), embree_ray(scene_.eye, direction, far_away));
        }
        return open >= fewest_open;
    }

    /// Splits the environment into sources, for shadow rays, and smooth light, for paths; measures albedos.
    void prepare_paths() {
        SplitLight split = split_light(scene_.environment);
        smooth_ = std::move(split.smooth);
        sources_ = SourceChoice(split.sources);
        for (const ShadedEntity& entity : scene_.entities) albedos_.push_back(mean_albedo(entity));
    }

    std::optional<SurfacePlace> first_point(const Vec3f& from, const Vec3f& direction) const {
        return triangles_.nearest(scene_, from, direction);
    }

    /// Returns the largest channel of the radiance of white paint in the light of the environment.
    double white_radiance(const SurfacePlace& point, std::uint32_t seed) const {
        std::mt19937 random(seed);
        const auto number = [&random] { return float(random() >> 8) / float(1 << 24); };
        Vec3d sum(0.0);
        for (std::uint32_t path = 0; path < paths; ++path) {
            SurfacePlace at = point;
            Rgb carried(static_cast<float>(white));
            for (int reflection = 0;; ++reflection) {
                sum += Vec3d(carried * source_radiance(at, double(number())));
                const Vec2f place = reflection == 0 ? sobol_point(path) : Vec2f(number(), number());
                const Vec3f direction = cosine_direction(place, at.normal, axes_across(at.normal));
                const std::optional<SurfacePlace> next = first_point(at.from, direction);
                if (!next) sum += Vec3d(carried * radiance_from(smooth_, Vec3d(direction)));
                if (!next || reflection == reflections) break;
                at = *next;
                // Russian roulette.
                const Rgb& albedo = albedos_[scene_.instances[at.instance].entity];
                const double chance = std::min(1.0, largest(albedo));
                if (!(double(number()) < chance)) break;
                carried *= albedo / static_cast<float>(chance);
            }
        }
        return largest(Rgb(sum / double(paths)));
    }

    /// Returns the largest channel of the radiance of white paint in the light of the lamps, without shadows.
    double lamp_radiance(const SurfacePlace& point) const {
        Vec3d sum(0.0);
        for (const Lamp& lamp : scene_.lamps) {
            const LampLight light = lamp_light(lamp, Vec3d(point.from));
            sum += Vec3d(lamp.colour) *
                   (white * light.share * std::max(0.0, Vec3d(point.normal).dot(light.direction)));
        }
        return largest(Rgb(sum));
    }

    /// Returns the largest channel of the radiance of white paint in the light of the emitters.
    double emitter_radiance(const SurfacePlace& point) const {
        constexpr float before = 1 - 1e-3f;  // excludes the emitter itself
        std::vector<EmitterPatch> patches;
        find_patches(emitters_, point.from, point.normal, {}, patches);
        Rgb irradiance(0.0f);
        for (const EmitterPatch& patch : patches) {
            const Vec3f towards = patch.place - point.from;
            if (!meets_any(triangles_.scene(),
                           embree_ray(point.from, towards.normalized(), towards.length() * before)))
                irradiance += patch.irradiance;
        }
        return white * largest(irradiance) / pi;
    }

private:
    /// Estimates the radiance of a surface of albedo 1 by one randomly chosen light of the sources.
    Rgb source_radiance(const SurfacePlace& point, double drawn) const {
        const std::optional<SourceChoice::Chosen> chosen = sources_.choose(drawn);
        const double cosine = chosen ? double(point.normal.dot(chosen->light.direction)) : 0;
        if (!(cosine > 0) ||
            meets_any(triangles_.scene(), embree_ray(point.from, chosen->light.direction, far_away)))
            return Rgb(0.0f);
        return chosen->light.irradiance * static_cast<float>(cosine / (pi * chosen->chance));
    }

    const ShadedScene& scene_;
    const EmitterTree emitters_;
    InstancedTriangles triangles_;
    std::vector<Rgb> albedos_;  ///< By entity.
    LatLongImage smooth_;
    SourceChoice sources_;
};

}  // namespace

float room_exposure(const ShadedScene& scene, std::span<const Vec3f> directions) {
    constexpr double least = 1.0 / 16, most_stops = 20, clipped = 0.1;
    Room room(scene);
    if (room.is_open()) return 0;
    room.prepare_paths();
    std::vector<double> radiances(directions.size(), -1);  // relative to what lamps leave; -1: no surface
    tbb::parallel_for(std::size_t(0), directions.size(), [&](std::size_t i) {
        if (const std::optional<SurfacePlace> point = room.first_point(scene.eye, directions[i].normalized()))
            radiances[i] = room.white_radiance(*point, static_cast<std::uint32_t>(i)) /
                           std::max(1 - room.lamp_radiance(*point) - room.emitter_radiance(*point), least);
    });
    std::erase(radiances, -1);
    if (radiances.empty()) return 0;
    const auto brightest =
        radiances.begin() + static_cast<std::ptrdiff_t>((1 - clipped) * double(radiances.size() - 1));
    std::ranges::nth_element(radiances, brightest);
    return *brightest > 0 ? static_cast<float>(std::clamp(-std::log2(*brightest), 0.0, most_stops)) : 0;
}

}  // namespace haarfield
