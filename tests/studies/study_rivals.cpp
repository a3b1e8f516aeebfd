#include <fmt/format.h>

#include <cmath>
#include <functional>

#include "fields/base/parallel_loop.h"
#include "scenes/scene_bake.h"
#include "scenes/scene_environment.h"
#include "scenes/scene_shading.h"
#include "shading/bake/path_tracer.h"
#include "shading/bake/ray_renderer.h"
#include "shading/bake/scrambled_sobol.h"
#include "shading/visibility/placed_solids.h"
#include "tests/baselines/scene_integrals.h"
#include "tests/studies/study.h"
#include "tests/studies/study_scenes.h"
#include "tools/stopwatch.h"

namespace haarfield::baseline {
namespace {

/// Returns the times of `repeats` runs: the smallest of each.
template <class Run>
RunTime spent(int repeats, const Run& run) {
    RunTime least{INFINITY, INFINITY};
    for (int repeat = 0; repeat < repeats; ++repeat) {
        const Stopwatch watch;
        run();
        const RunTime time = watch.elapsed();
        least = {std::min(least.wall, time.wall), std::min(least.processor, time.processor)};
    }
    return least;
}

RunTime sum(RunTime a, const RunTime& b) {
    return a += b;
}

/// A row of the table.
struct RivalRow {
    std::string name;
    std::string light;  ///< Of Blender's environments; empty: an overcast sky.
    std::function<Scene(const std::filesystem::path& folder)> scene;
};

Scene shipped(const std::filesystem::path&) {
    return shipped_scene().description;
}

/// Returns a hundred chairs with few vertices each.
Scene hundred_chairs(const std::filesystem::path&) {
    Scene scene = crowd(shipped_scene().description, 10, 10, false);
    constexpr std::uint32_t chair_vertices = 2000;
    for (Entity& entity : scene.entities)
        if (entity.name == "chair") entity.fine_vertices = chair_vertices;
    return scene;
}

std::vector<RivalRow> all_rows() {
    return {{"interior", "interior", shipped},     {"sunrise", "sunrise", shipped},
            {"forest", "forest", shipped},         {"overcast", "", shipped},
            {"scan", "forest", scanned_model},     {"parts", "forest", model_of_parts},
            {"pieces", "forest", model_of_pieces}, {"cards", "forest", leaf_cards},
            {"chairs", "forest", hundred_chairs}};
}

/// Returns the sky of the CIE's overcast standard, above a dark ground.
LatLongImage overcast_sky() {
    LatLongImage image{512, 256, {}};
    for (int y = 0; y < image.height; ++y) {
        const double height = std::sin(pi * (0.5 - (y + 0.5) / image.height));
        const Rgb radiance(float(height > 0 ? (1 + 2 * height) / 3 : 0.1));
        image.pixels.insert(image.pixels.end(), std::size_t(image.width), radiance);
    }
    return image;
}

Environment light_of(const std::string& name) {
    if (name.empty()) return overcast_sky();
    Scene scene;
    scene.environment.image = "/usr/share/blender/datafiles/studiolights/world/" + name + ".exr";
    return value_or_exit(scene_environment(scene)).environment;
}

/// Two independent estimates of the radiance of a vertex.
struct TrueVertex {
    std::size_t instance = 0;
    std::uint32_t vertex = 0;
    std::array<Vec3d, 2> direct{Vec3d(0.0), Vec3d(0.0)}, all{Vec3d(0.0), Vec3d(0.0)};
};

/// Returns the truth at vertices that are neither buried nor touch another object.
std::vector<TrueVertex> true_vertices(const ShadedScene& scene, std::size_t wanted) {
    constexpr std::uint32_t samples = 4096, paths = 1024;
    std::vector<std::pair<std::size_t, std::uint32_t>> candidates;
    const PlacedSolids solids(scene);
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const ShadedEntity& entity = scene.entities[scene.instances[i].entity];
        const std::vector<std::uint8_t> buried =
            solids.buried_vertices(scene, i, *entity.mesh, entity.occlusion->samples());
        for (std::uint32_t v = 0; v < buried.size(); ++v)
            if (buried[v] == 0) candidates.emplace_back(i, v);
    }
    std::vector<TrueVertex> truth;
    for (std::size_t k = 0; k < std::min(wanted, candidates.size()); ++k) {
        const double place = (double(k) + 0.37) * 0.6180339887498949;  // spread by the golden ratio
        const auto [instance, vertex] =
            candidates[std::size_t((place - std::floor(place)) * double(candidates.size()))];
        TrueVertex& at = truth.emplace_back();
        at.instance = instance;
        at.vertex = vertex;
    }
    const RayScene rays(scene);
    const FineSurface surface(scene);
    const PathTracer tracer(rays, surface);
    (void)parallel_loop(
        {truth.size()},
        [&]() -> LoopBody {
            return [&](std::size_t k) {
                TrueVertex& at = truth[k];
                const ShadedInstance& instance = scene.instances[at.instance];
                const SurfacePoint point = surface_point(scene.entities[instance.entity], at.vertex);
                const ShadingPoint seen = shading_point(scene, instance, point);
                for (std::uint32_t r = 0; r < 2; ++r) {
                    const std::uint32_t seed = mixed_seed(0x7e000000u + r, std::uint32_t(k));
                    at.direct[r] = Vec3d(ray_radiance(rays, at.instance, point, samples, seed).total());
                    at.all[r] = at.direct[r] +
                                Vec3d(tracer.indirect_radiance(seen.from, seen.brdf, paths, seed).total());
                }
            };
        },
        "", {});
    std::erase_if(truth, [](const TrueVertex& at) { return at.direct[0] == Vec3d(0.0); });
    return truth;
}

/// Returns the error of radiance by instance and vertex: the root of mean((b - r1) (b - r2)).
template <class Radiance>
double error_of(const std::vector<TrueVertex>& truth, bool direct, const Radiance& radiance) {
    std::vector<std::array<double, 2>> sums(truth.size());
    (void)parallel_loop({truth.size()},
                        [&]() -> LoopBody {
                            return [&](std::size_t k) {
                                const std::array<Vec3d, 2>& exact = direct ? truth[k].direct : truth[k].all;
                                const Vec3d found(radiance(truth[k].instance, truth[k].vertex).total());
                                sums[k] = {(found - exact[0]).dot(found - exact[1]), exact[0].dot(exact[1])};
                            };
                        },
                        "", {});
    double error = 0, all = 0;
    for (const auto& [square, energy] : sums) {
        error += square;
        all += energy;
    }
    return std::sqrt(std::max(0.0, error / all));
}

/// Returns the number of samples with which rays have an error.
double equal_samples(const ShadedScene& scene, const std::vector<TrueVertex>& truth, int bounces,
                     double wanted) {
    constexpr std::uint32_t least = 4, most = 1u << 14;
    double before = 0;
    for (std::uint32_t samples = least;; samples *= 4) {
        const RayShader shader(scene, {samples, bounces});
        const double error = error_of(truth, bounces == 0, [&](std::size_t instance, std::uint32_t vertex) {
            return shader.radiance(instance, vertex);
        });
        if (error <= wanted || samples == most) {
            if (samples == least) return least;
            const double slope = std::log(before / error) / std::log(4.0);
            return samples * std::pow(error / wanted, 1 / std::max(slope, 0.3));
        }
        before = error;
    }
}

void print_line(const std::string& name, const char* light, std::size_t vertices, double error,
                double samples, const std::array<RunTime, 4>& times) {
    const auto& [cold, warm, rays_cold, rays_warm] = times;
    fmt::print("{:<22} {:>9} {:>6.2f} {:>7.0f}", fmt::format("{}, {}", name, light), vertices, 100 * error,
               samples);
    for (const RunTime& time : {cold, rays_cold, warm, rays_warm})
        fmt::print(" {:>8.2f} {:>7.2f}", time.processor, time.wall);
    fmt::print(" {:>6.2f} {:>6.2f} {:>6.2f} {:>6.2f}\n", rays_cold.processor / cold.processor,
               rays_cold.wall / cold.wall, rays_warm.processor / warm.processor, rays_warm.wall / warm.wall);
    std::fflush(stdout);
}

/// Measures one scene.
void measure(const RivalRow& row, const RivalStudyOptions& options) {
    const std::filesystem::path folder = study_fields_folder() / "rivals";
    std::filesystem::remove_all(folder);
    Scene scene = row.scene(folder / "models");
    for (Entity& entity : scene.entities)
        for (std::uint32_t Entity::*count :
             {&Entity::fine_vertices, &Entity::planar_samples, &Entity::spherical_samples})
            entity.*count = std::max(1u, std::uint32_t(double(entity.*count) * options.scale));
    SceneEntityOptions with_fields, without;
    with_fields.fields_folder = without.fields_folder = folder / "fields";
    without.fields = FieldExtent::none;
    // Without a library, nothing is stored.
    const RunTime meshes_cold =
        spent(options.repeats, [&] { (void)value_or_exit(prepare_scene_entities(scene, without)); });
    const RunTime fields_cold =
        spent(1, [&] { (void)value_or_exit(prepare_scene_entities(scene, with_fields)); });
    SceneEntities entities, meshes;
    const RunTime fields_warm =
        spent(options.repeats, [&] { entities = value_or_exit(prepare_scene_entities(scene, with_fields)); });
    const RunTime meshes_warm =
        spent(options.repeats, [&] { meshes = value_or_exit(prepare_scene_entities(scene, without)); });
    const Environment light = light_of(row.light);
    const ShadedScene shaded = shaded_scene(scene, entities, light),
                      bare = shaded_scene(scene, meshes, light);
    const std::vector<TrueVertex> truth = true_vertices(bare, options.points);

    for (const int bounces : {0, any_bounces}) {
        RenderSettings settings;
        settings.bounces.most = bounces;
        BakedScene baked;
        const RunTime bake = spent(options.repeats, [&] {
            baked = value_or_exit(baked_scene(scene, entities, shaded, settings, {}));
        });
        std::size_t vertices = 0;
        for (const BakedInstance& instance : baked.instances) vertices += instance.radiance.size();
        const double error =
            error_of(truth, bounces == 0, [&](std::size_t instance, std::uint32_t vertex) -> const Outgoing& {
                return baked.fine[instance][vertex];
            });
        const double samples = equal_samples(bare, truth, bounces, error);
        BakeOptions by_rays;
        by_rays.evaluator = Evaluator::rays;
        const auto rays = [&](double count) {
            by_rays.samples = std::uint32_t(std::lround(count));
            return spent(options.repeats,
                         [&] { (void)value_or_exit(baked_scene(scene, meshes, bare, settings, by_rays)); });
        };
        constexpr double few = 64, many = 256;
        RunTime by_samples = rays(std::min(samples, many));
        if (samples > many) {
            const RunTime less = rays(few);
            const double further = (samples - many) / (many - few);
            by_samples = {by_samples.wall + further * (by_samples.wall - less.wall),
                          by_samples.processor + further * (by_samples.processor - less.processor)};
        }
        print_line(row.name, bounces == 0 ? "direct" : "all", vertices, error, samples,
                   {sum(fields_cold, bake), sum(fields_warm, bake), sum(meshes_cold, by_samples),
                    sum(meshes_warm, by_samples)});
    }
}

}  // namespace

std::vector<std::string> rival_rows() {
    std::vector<std::string> names;
    for (const RivalRow& row : all_rows()) names.push_back(row.name);
    return names;
}

void study_rivals(const RivalStudyOptions& options) {
    fmt::print("{:<22} {:>9} {:>6} {:>7}{:^34}{:^34}{:^28}\n", "", "", "", "", "cold: haarfield, rays [s]",
               "warm: haarfield, rays [s]", "ratio");
    fmt::print("{:<22} {:>9} {:>6} {:>7}", "scene", "vertices", "%", "samples");
    for (int column = 0; column < 4; ++column) fmt::print(" {:>8} {:>7}", "CPU", "wall");
    fmt::print(" {:>6} {:>6} {:>6} {:>6}\n", "cold", "wall", "warm", "wall");
    for (const RivalRow& row : all_rows())
        if (std::ranges::find(options.rows, row.name) != options.rows.end()) measure(row, options);
}

}  // namespace haarfield::baseline
