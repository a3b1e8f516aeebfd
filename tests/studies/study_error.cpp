#include <fmt/format.h>

#include <cmath>

#include "bridge/pictures/preview.h"
#include "fields/base/parallel_loop.h"
#include "scenes/bake_search.h"
#include "scenes/scene_bake.h"
#include "scenes/scene_camera.h"
#include "scenes/scene_environment.h"
#include "scenes/scene_reader.h"
#include "scenes/scene_shading.h"
#include "shading/bake/path_tracer.h"
#include "shading/bake/ray_renderer.h"
#include "shading/bake/scrambled_sobol.h"
#include "shading/scene/turned_light.h"
#include "tests/baselines/product_methods.h"
#include "tests/studies/study.h"
#include "tools/stopwatch.h"

namespace haarfield::baseline {
namespace {

/// Two independent estimates of the radiance at a pixel.
struct TruePixel {
    std::size_t pixel = 0;
    DisplayedPoint displayed;
    std::array<Vec3d, 2> radiance;
};

/// Returns the truth at pixels of the picture, by rays and paths. They share no points with a search.
std::vector<TruePixel> true_pixels(const SceneEntities& entities, const ShadedScene& shaded,
                                   const Camera& camera, const RenderSettings& settings, std::size_t wanted) {
    const auto pixels = Preview().points(camera, preview_instances(entities, shaded));
    const std::vector<DisplayedPoint> all = displayed_points(entities, shaded, pixels);
    const RayScene rays(shaded);
    const FineSurface surface(shaded);
    const PathTracer paths(rays, surface);
    std::vector<TruePixel> points;
    for (std::size_t k = 0; k < wanted && !all.empty(); ++k) {
        const DisplayedPoint& point =
            all[std::size_t((double(k) + 0.37) / double(wanted) * double(all.size()))];
        if (surface_point(shaded.entities[shaded.instances[point.at.instance].entity], point.at))
            points.push_back({point.pixel, point, {}});
    }
    (void)parallel_loop({points.size()},
                        [&]() -> LoopBody {
                            return [&](std::size_t k) {
                                TruePixel& point = points[k];
                                const std::size_t i = point.displayed.at.instance;
                                const ShadedInstance& instance = shaded.instances[i];
                                const ShadedEntity& entity = shaded.entities[instance.entity];
                                const SurfacePoint at = *surface_point(entity, point.displayed.at);
                                const ShadingPoint seen = shading_point(shaded, instance, at);
                                for (std::uint32_t r = 0; r < 2; ++r) {
                                    const std::uint32_t seed = mixed_seed(0x7f000000u + r, std::uint32_t(k));
                                    Outgoing radiance = ray_radiance(rays, i, at, 4096, seed);
                                    if (settings.bounces.most > 0)
                                        radiance += paths.indirect_radiance(seen.from, seen.brdf, 1024, seed);
                                    point.radiance[r] = point.displayed.displayed(radiance);
                                }
                            };
                        },
                        "", {});
    return points;
}

/// Returns the error of a bake: the root of mean((b - r1) (b - r2)), to which noise does not contribute.
double true_error(const BakedScene& baked, const Camera& camera, const std::vector<TruePixel>& truth) {
    const auto pixels = Preview().points(camera, baked.instances);
    double error = 0, all = 0;
    for (const TruePixel& point : truth) {
        const std::optional<MeshPoint>& at = pixels[point.pixel];
        if (!at || at->instance != point.displayed.at.instance) continue;
        const Mesh& mesh = *baked.instances[at->instance].mesh;
        const std::vector<Outgoing>& values =
            baked.refined.empty() ? baked.fine[at->instance] : baked.refined[at->instance].radiance;
        Outgoing shown;
        for (std::size_t c = 0; c < 3; ++c)
            shown += values[mesh.triangles[at->triangle][c]] * at->weights()[c];
        const Vec3d here = point.displayed.displayed(shown);
        error += (here - point.radiance[0]).dot(here - point.radiance[1]);
        all += point.radiance[0].dot(point.radiance[1]);
    }
    return error > 0 ? std::sqrt(error / all) : -std::sqrt(-error / all);
}

}  // namespace

void study_error(const std::string& file, const ErrorStudyOptions& options) {
    Scene scene = value_or_exit(read_scene(file));
    if (!options.environment.empty()) scene.environment.image = options.environment;
    if (!options.environment.empty()) scene.environment.sky.reset();
    if (options.width > 0) {
        scene.camera.height = std::max(1, scene.camera.height * options.width / scene.camera.width);
        scene.camera.width = options.width;
    }
    SceneEnvironment light = value_or_exit(scene_environment(scene));
    RenderSettings settings;
    settings.bounces.most = any_bounces;
    SceneEntityOptions meshes;
    meshes.fields = search_fields(scene, settings.occlusion);
    const Stopwatch preparation;
    const SceneEntities searched = value_or_exit(prepare_scene_entities(search_start(scene), meshes));
    const double prepared = preparation.elapsed().processor;
    scene.camera = scene_camera(scene, searched);
    scene.finds_camera = false;
    if (const float stops = entity_stops(scene, searched, light.environment); stops != 0)
        light.environment = turned_environment(light.environment, 0, double(stops));
    const ShadedScene shaded = shaded_scene(scene, searched, light.environment);
    const std::vector<TruePixel> truth =
        true_pixels(searched, shaded, scene.camera, settings, options.pixels);
    fmt::print("{:<28} {:>9} {:>9} {:>9} {:>8} {:>8} {:>18} {:>8} {:>8} {:>8} {:>6}\n", "bake", "vertices",
               "cold CPU", "warm CPU", "true %", "said %", "90 %", "between", "vertex", "indirect", "rays");
    for (const std::string& target : options.targets) {
        BakeOptions bake;
        if (target == "refine")
            bake.refine = 0.01f;
        else if (target != "off")
            bake.error = std::stod(target) / 100;
        SceneEntities own;
        double cold = prepared, warm = prepared;
        if (!bake.error) {
            SceneEntityOptions whole;
            whole.fields_folder = study_fields_folder();
            std::filesystem::remove_all(whole.fields_folder);
            const Stopwatch first;
            (void)value_or_exit(prepare_scene_entities(scene, whole));
            cold = first.elapsed().processor;
            const Stopwatch second;
            own = value_or_exit(prepare_scene_entities(scene, whole));
            warm = second.elapsed().processor;
        }
        const SceneEntities& entities = bake.error ? searched : own;
        const ShadedScene lit = shaded_scene(scene, entities, light.environment);
        const Stopwatch watch;
        const auto pixels = bake.error ? Preview().points(scene.camera, preview_instances(entities, lit))
                                       : std::vector<std::optional<MeshPoint>>();
        const BakedScene baked =
            value_or_exit(baked_scene(scene, entities, lit, settings, bake, {}, nullptr, pixels));
        const double spent = watch.elapsed().processor;
        std::size_t vertices = 0;
        for (const BakedInstance& instance : baked.instances) vertices += instance.radiance.size();
        const double error = true_error(baked, scene.camera, truth);
        fmt::print("{:<28} {:>9} {:>9.1f} {:>9.1f} {:>8.2f}", target, vertices, cold + spent, warm + spent,
                   100 * error);
        if (baked.search) {
            const BakeError& said = baked.search->error;
            fmt::print(" {:>8.2f} {:>18} {:>8.2f} {:>8.2f} {:>8.2f} {:>6} {}", 100 * said.total,
                       fmt::format("{:.2f} to {:.2f}", 100 * said.low, 100 * said.high), 100 * said.between,
                       100 * said.at_vertices, 100 * said.indirect, baked.search->gathering_rays,
                       baked.search->fitted ? "fitted" : "sampled");
        }
        fmt::print("\n");
        std::fflush(stdout);
    }
}

}  // namespace haarfield::baseline
