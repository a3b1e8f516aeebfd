#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "bridge/pictures/preview.h"
#include "fields/base/parallel_loop.h"
#include "fields/file/write_file.h"
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
        // One pixel of each run at random: a regular choice could follow a shadow edge.
        const double place = double(mixed_seed(37, std::uint32_t(k))) * 0x1p-32;
        const DisplayedPoint& point =
            all[std::size_t((double(k) + place) / double(wanted) * double(all.size()))];
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

/// The true error of a bake.
struct TrueError {
    double error = 0;            ///< Relative RMSE; negative if noise makes its square negative.
    double low = 0, high = 0;    ///< The 90 % interval by resampling of the pixels.
    std::vector<double> shares;  ///< Of the sum of squares, by pixel of the truth.
    std::vector<Vec3d> shown;    ///< By pixel of the truth.
};

double signed_root(double square) {
    return square > 0 ? std::sqrt(square) : -std::sqrt(-square);
}

/// Returns the error of a bake: the root of mean((b - r1) (b - r2)), to which noise does not contribute.
TrueError true_error(const BakedScene& baked, const Camera& camera, const std::vector<TruePixel>& truth) {
    const auto pixels = Preview().points(camera, baked.instances);
    TrueError result;
    std::vector<double> sizes;
    for (const TruePixel& point : truth) {
        result.shares.push_back(0);
        result.shown.emplace_back(0.0);
        sizes.push_back(0);
        const std::optional<MeshPoint>& at = pixels[point.pixel];
        if (!at || at->instance != point.displayed.at.instance) continue;
        const Mesh& mesh = *baked.instances[at->instance].mesh;
        const std::vector<Outgoing>& values =
            baked.refined.empty() ? baked.fine[at->instance] : baked.refined[at->instance].radiance;
        Outgoing shown;
        for (std::size_t c = 0; c < 3; ++c)
            shown += values[mesh.triangles[at->triangle][c]] * at->weights()[c];
        const Vec3d here = point.displayed.displayed(shown);
        result.shown.back() = here;
        result.shares.back() = (here - point.radiance[0]).dot(here - point.radiance[1]);
        sizes.back() = point.radiance[0].dot(point.radiance[1]);
    }
    const double all = std::accumulate(sizes.begin(), sizes.end(), 0.0);
    const double error = std::accumulate(result.shares.begin(), result.shares.end(), 0.0);
    result.error = signed_root(error / all);
    std::vector<double> resampled;
    std::mt19937 random(37);
    for (int n = 0; n < 400; ++n) {
        double errors = 0, whole = 0;
        for (std::size_t k = 0; k < sizes.size(); ++k) {
            const std::size_t drawn = random() % sizes.size();
            errors += result.shares[drawn];
            whole += sizes[drawn];
        }
        resampled.push_back(signed_root(errors / whole));
    }
    std::ranges::sort(resampled);
    result.low = resampled[20];
    result.high = resampled[380];
    for (double& share : result.shares) share /= error;
    return result;
}

const char* end_of(SearchEnd end) {
    switch (end) {
        case SearchEnd::reached: return "reached";
        case SearchEnd::vertex_budget: return "vertex budget";
        case SearchEnd::short_edges: return "short edges";
        case SearchEnd::little_gain: return "little gain";
        case SearchEnd::direct_light: return "direct light";
        case SearchEnd::indirect_light: return "indirect light";
    }
    return "";
}

/// Draws a bake, and lists the pixels with the largest shares of its square error.
void write_findings(const std::filesystem::path& file, const BakedScene& baked, const Camera& camera,
                    const std::vector<TruePixel>& truth, const TrueError& error,
                    const LatLongImage& background) {
    const Image picture = Preview().draw(camera, baked.instances, [&](const Vec3f& direction) {
        return radiance_from(background, Vec3d(direction));
    });
    value_or_exit(write_image(picture, file.string() + ".png"));
    std::vector<std::size_t> order(truth.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::ranges::stable_sort(order, std::ranges::greater(), [&](std::size_t k) { return error.shares[k]; });
    std::string lines = "column,row,instance,share,shown green,first green,second green\n";
    for (const std::size_t k : order)
        lines +=
            fmt::format("{},{},{},{:.6f},{:.5g},{:.5g},{:.5g}\n", truth[k].pixel % std::size_t(camera.width),
                        truth[k].pixel / std::size_t(camera.width), truth[k].displayed.at.instance,
                        error.shares[k], error.shown[k].y, truth[k].radiance[0].y, truth[k].radiance[1].y);
    value_or_exit(write_file(file.string() + ".csv", lines));
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
    fmt::print("{:<8} {:>8} {:>8} {:>8} {:>7} {:>13} {:>7} {:>13} {:>7} {:>7} {:>8} {:>5}\n", "bake",
               "vertices", "cold CPU", "warm CPU", "true %", "90 %", "said %", "90 %", "between", "vertex",
               "indirect", "rays");
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
        const SceneEntities* entities = bake.error ? &searched : &own;
        ShadedScene lit;
        const Stopwatch watch;
        const BakeAttempt attempt = [&](std::optional<std::uint32_t> start, const BakeOptions& chosen) {
            if (start && *start != search_start_vertices) {
                own = value_or_exit(prepare_scene_entities(search_start(scene, *start), meshes));
                entities = &own;
            }
            lit = shaded_scene(scene, *entities, light.environment);
            const auto pixels = bake.error ? Preview().points(scene.camera, preview_instances(*entities, lit))
                                           : std::vector<std::optional<MeshPoint>>();
            return baked_scene(scene, *entities, lit, settings, chosen, {}, nullptr, pixels);
        };
        const BakedScene baked = value_or_exit(repeated_bake(bake, attempt));
        const double spent = watch.elapsed().processor;
        std::size_t vertices = 0;
        for (const BakedInstance& instance : baked.instances) vertices += instance.radiance.size();
        const TrueError error = true_error(baked, scene.camera, truth);
        fmt::print("{:<8} {:>8} {:>8.1f} {:>8.1f} {:>7.2f} {:>13}", target, vertices, cold + spent,
                   warm + spent, 100 * error.error,
                   fmt::format("{:.2f} to {:.2f}", 100 * error.low, 100 * error.high));
        if (baked.search) {
            const BakeError& said = baked.search->error;
            fmt::print(" {:>7.2f} {:>13} {:>7.2f} {:>7.2f} {:>8.2f} {:>5} {}, {}, {} cut edges",
                       100 * said.total, fmt::format("{:.2f} to {:.2f}", 100 * said.low, 100 * said.high),
                       100 * said.between, 100 * said.at_vertices, 100 * said.indirect,
                       baked.search->gathering_rays, baked.search->fitted ? "fitted" : "sampled",
                       end_of(baked.search->end), baked.search->cut_edges);
        }
        if (!options.pictures.empty())
            write_findings(options.pictures / (std::filesystem::path(file).stem().string() + "-" + target),
                           baked, scene.camera, truth, error, image_with_suns(light.environment));
        fmt::print("\n");
        std::fflush(stdout);
    }
}

}  // namespace haarfield::baseline
