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

/// Samples and paths of each of two independent estimates: rough ones at all pixels, accurate ones at some.
constexpr std::uint32_t rough_samples = 32, rough_paths = 8, samples = 4096, paths = 1024;

/// Estimates of the radiance at the pixels of a picture, by rays and paths. They share no points with a
/// search.
class TruePicture {
public:
    TruePicture(const SceneEntities& entities, const ShadedScene& shaded, const Camera& camera,
                const RenderSettings& settings)
        : shaded_(shaded),
          points_(unburied_points(entities, shaded, camera)),
          rays_(focused_rays(shaded, points_)),
          surface_(shaded),
          tracer_(rays_, surface_) {
        has_bounces_ = settings.bounces.most > 0;
        rough_.resize(points_.size());
        for_each_point(points_.size(), [&](std::size_t k) {
            rough_[k] = estimates(points_[k], rough_samples, rough_paths, std::uint32_t(k));
        });
        for (const auto& [first, second] : rough_) square_ += first.dot(second);
    }

    const std::vector<DisplayedPoint>& points() const { return points_; }
    /// Returns the mesh that the points of an instance refer to.
    const Mesh& mesh(std::size_t instance) const {
        return *shaded_.entities[shaded_.instances[instance].entity].mesh;
    }
    /// Two rough estimates by point. [W/(m^2 sr)]
    const std::vector<std::array<Vec3d, 2>>& rough() const { return rough_; }
    /// The sum of the squares of the radiance. [(W/(m^2 sr))^2]
    double square() const { return square_; }

    /// Returns two accurate estimates for each of these points.
    std::vector<std::array<Vec3d, 2>> accurate(std::span<const std::size_t> numbers) const {
        std::vector<std::array<Vec3d, 2>> result(numbers.size());
        for_each_point(numbers.size(), [&](std::size_t k) {
            result[k] = estimates(points_[numbers[k]], samples, paths, 0x40000000u + std::uint32_t(k));
        });
        return result;
    }

private:
    static std::vector<DisplayedPoint> unburied_points(const SceneEntities& entities,
                                                       const ShadedScene& shaded, const Camera& camera) {
        std::vector<DisplayedPoint> points =
            displayed_points(entities, shaded, Preview().points(camera, preview_instances(entities, shaded)));
        std::erase_if(points, [&](const DisplayedPoint& point) {
            return !surface_point(shaded.entities[shaded.instances[point.at.instance].entity], point.at);
        });
        return points;
    }

    static RayScene focused_rays(const ShadedScene& shaded, std::span<const DisplayedPoint> points) {
        constexpr std::size_t most = 512;
        const std::size_t count = std::min(most, points.size());
        RayScene rays(shaded);
        std::vector<SurfacePlace> places;
        for (std::size_t k = 0; k < count; ++k) {
            const MeshPoint& at = points[k * points.size() / count].at;
            const ShadedInstance& instance = shaded.instances[at.instance];
            const ShadingPoint seen =
                shading_point(shaded, instance, *surface_point(shaded.entities[instance.entity], at));
            places.push_back({seen.from, seen.brdf.normal});
        }
        rays.focus(places);
        return rays;
    }

    template <class Body>
    static void for_each_point(std::size_t count, const Body& body) {
        (void)parallel_loop({count}, [&]() -> LoopBody { return body; }, "", {});
    }

    std::array<Vec3d, 2> estimates(const DisplayedPoint& displayed, std::uint32_t by_rays,
                                   std::uint32_t by_paths, std::uint32_t number) const {
        const std::size_t i = displayed.at.instance;
        const ShadedInstance& instance = shaded_.instances[i];
        const SurfacePoint at = *surface_point(shaded_.entities[instance.entity], displayed.at);
        const ShadingPoint seen = shading_point(shaded_, instance, at);
        std::array<Vec3d, 2> result;
        for (std::uint32_t r = 0; r < 2; ++r) {
            const std::uint32_t seed = mixed_seed(0x7f000000u + r, number);
            Outgoing radiance = ray_radiance(rays_, i, at, by_rays, seed);
            if (has_bounces_) radiance += tracer_.indirect_radiance(seen.from, seen.brdf, by_paths, seed);
            result[r] = displayed.displayed(radiance);
        }
        return result;
    }

    const ShadedScene& shaded_;
    const std::vector<DisplayedPoint> points_;
    const RayScene rays_;
    const FineSurface surface_;
    const PathTracer tracer_;
    bool has_bounces_ = false;
    std::vector<std::array<Vec3d, 2>> rough_;
    double square_ = 0;
};

/// The error at a pixel of the sample.
struct PixelError {
    DisplayedPoint displayed;
    Vec3d shown{0.0};              ///< [W/(m^2 sr)]
    std::array<Vec3d, 2> truth{};  ///< [W/(m^2 sr)]
    double share = 0;              ///< Its estimated share of the sum of squares over the picture.
};

/// The true error of a bake.
struct TrueError {
    double error = 0;          ///< Relative RMSE; negative if noise makes its square negative.
    double low = 0, high = 0;  ///< The 90 % interval by resampling of the pixels.
    std::vector<PixelError> pixels;
};

double signed_root(double square) {
    return square > 0 ? std::sqrt(square) : -std::sqrt(-square);
}

/// Returns the place of a point of a mesh.
Vec3f position(const Mesh& mesh, const MeshPoint& point) {
    Vec3f sum(0.0f);
    for (std::size_t c = 0; c < 3; ++c)
        sum += mesh.positions[mesh.triangles[point.triangle][c]] * point.weights()[c];
    return sum;
}

/// Returns what a bake shows at the points of a picture. An entry is empty if the refined mesh shows another
/// surface there than the fine mesh. Rounding causes this at a few pixels next to silhouettes.
std::vector<std::optional<Vec3d>> shown_radiance(const BakedScene& baked, const Camera& camera,
                                                 const TruePicture& picture) {
    const auto pixels = Preview().points(camera, baked.instances);
    std::vector<float> radii;
    for (const BakedInstance& instance : baked.instances)
        radii.push_back(mesh_bounds(*instance.mesh).radius());
    std::vector<std::optional<Vec3d>> result;
    for (const DisplayedPoint& point : picture.points()) {
        result.emplace_back();
        const std::optional<MeshPoint>& at = pixels[point.pixel];
        if (!at || at->instance != point.at.instance) continue;
        const Mesh& mesh = *baked.instances[at->instance].mesh;
        const Vec3f expected = position(picture.mesh(at->instance), point.at);
        if ((position(mesh, *at) - expected).length() > 1e-3f * radii[at->instance]) continue;
        const std::vector<Outgoing>& values =
            baked.refined.empty() ? baked.fine[at->instance] : baked.refined[at->instance].radiance;
        Outgoing shown;
        for (std::size_t c = 0; c < 3; ++c)
            shown += values[mesh.triangles[at->triangle][c]] * at->weights()[c];
        result.back() = point.displayed(shown);
    }
    return result;
}

/// Returns the error of a bake: the root of mean((b - r1) (b - r2)), to which noise does not contribute.
///
/// Half of the pixels are chosen uniformly and half in proportion to their square error by the rough
/// estimates, which finds errors in few pixels. Each counts by the reciprocal of its probability.
TrueError true_error(const BakedScene& baked, const Camera& camera, const TruePicture& picture,
                     std::size_t wanted) {
    const std::vector<DisplayedPoint>& points = picture.points();
    const std::vector<std::optional<Vec3d>> shown = shown_radiance(baked, camera, picture);
    std::vector<double> probabilities;
    double all = 0;
    for (std::size_t k = 0; k < points.size(); ++k) {
        const Vec3d rough = (picture.rough()[k][0] + picture.rough()[k][1]) * 0.5;
        const Vec3d off = shown[k].value_or(rough) - rough;
        all += probabilities.emplace_back(off.dot(off));
    }
    for (double& each : probabilities)
        each = 0.5 / double(points.size()) + (all > 0 ? 0.5 * each / all : 0.5 / double(points.size()));
    // One pixel of each run of equal probability at random: a regular choice could follow a shadow edge.
    std::vector<std::size_t> numbers;
    double below = 0;
    for (std::size_t k = 0, n = 0; k < points.size() && n < wanted;) {
        const double place =
            (double(n) + double(mixed_seed(37, std::uint32_t(n))) * 0x1p-32) / double(wanted);
        if (below + probabilities[k] < place && k + 1 < points.size()) {
            below += probabilities[k++];
            continue;
        }
        numbers.push_back(k);
        ++n;
    }
    const std::vector<std::array<Vec3d, 2>> truth = picture.accurate(numbers);
    TrueError result;
    for (std::size_t n = 0; n < numbers.size(); ++n) {
        const std::size_t k = numbers[n];
        const double square = shown[k] ? (*shown[k] - truth[n][0]).dot(*shown[k] - truth[n][1]) : 0;
        result.pixels.push_back({points[k], shown[k].value_or(Vec3d(0.0)), truth[n],
                                 square / (probabilities[k] * double(numbers.size()) * picture.square())});
    }
    const auto sum = [](double before, const PixelError& pixel) { return before + pixel.share; };
    const double error = std::accumulate(result.pixels.begin(), result.pixels.end(), 0.0, sum);
    result.error = signed_root(error);
    std::vector<double> resampled;
    std::mt19937 random(37);
    for (int n = 0; n < 400 && !numbers.empty(); ++n) {
        double drawn = 0;
        for (std::size_t k = 0; k < numbers.size(); ++k)
            drawn += result.pixels[random() % numbers.size()].share;
        resampled.push_back(signed_root(drawn));
    }
    std::ranges::sort(resampled);
    if (!resampled.empty()) {
        result.low = resampled[20];
        result.high = resampled[380];
    }
    for (PixelError& pixel : result.pixels) pixel.share /= error;
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
                    TrueError error, const LatLongImage& background) {
    const Image picture = Preview().draw(camera, baked.instances, [&](const Vec3f& direction) {
        return radiance_from(background, Vec3d(direction));
    });
    value_or_exit(write_image(picture, file.string() + ".png"));
    std::ranges::stable_sort(error.pixels, std::ranges::greater(), &PixelError::share);
    std::string lines = "column,row,instance,share,shown green,first green,second green\n";
    for (const PixelError& pixel : error.pixels)
        lines += fmt::format("{},{},{},{:.6f},{:.5g},{:.5g},{:.5g}\n",
                             pixel.displayed.pixel % std::size_t(camera.width),
                             pixel.displayed.pixel / std::size_t(camera.width), pixel.displayed.at.instance,
                             pixel.share, pixel.shown.y, pixel.truth[0].y, pixel.truth[1].y);
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
        const TruePicture picture(*entities, lit, scene.camera, settings);  // of the meshes that were baked
        std::size_t vertices = 0;
        for (const BakedInstance& instance : baked.instances) vertices += instance.radiance.size();
        const TrueError error = true_error(baked, scene.camera, picture, options.pixels);
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
                           baked, scene.camera, error, image_with_suns(light.environment));
        fmt::print("\n");
        std::fflush(stdout);
    }
}

}  // namespace haarfield::baseline
