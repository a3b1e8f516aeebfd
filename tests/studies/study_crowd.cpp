#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "scenes/scene_entities.h"
#include "scenes/scene_shading.h"
#include "shading/scene/lighting.h"
#include "shading/transfer/radiance_transfer.h"
#include "tests/baselines/product_methods.h"
#include "tests/fixtures/relative_error.h"
#include "tests/studies/study.h"
#include "tests/studies/study_scenes.h"

namespace haarfield::baseline {
namespace {

/// Returns the resident memory of the process. [MB]
double resident_megabytes() {
    std::ifstream file("/proc/self/statm");
    double pages = 0;
    file >> pages >> pages;
    return pages * 4096 / 1e6;
}

/// The shading of some of a scene's vertices.
struct Shaded {
    double microseconds = 0;    ///< Minimum time per vertex.
    std::vector<Rgb> radiance;  ///< Of the vertices that are not buried.
};

Shaded shaded_vertices(const ShadedScene& scene, Occlusion occlusion, std::size_t vertices, int rounds = 3) {
    RenderSettings settings;
    settings.occlusion = occlusion;
    const ShadingGeometry geometry = value_or_exit(shading_geometry(scene, settings));
    const LightPyramid light = scene_light(scene.environment, settings).smooth;
    const VertexRows rows(scene, geometry);
    VertexTransfer vertex(scene, geometry, settings);
    constexpr std::size_t run = 64;
    Shaded result{INFINITY, {}};
    for (int round = 0; round < rounds; ++round) {
        const double start = thread_seconds();
        result.radiance.clear();
        for (std::size_t k = 0; k < vertices; ++k) {
            // Runs of neighbours, as in a bake, distributed evenly by the golden ratio.
            const double place = double(k / run) * 0.6180339887498949;
            const auto first =
                static_cast<std::size_t>((place - std::floor(place)) * double(rows.count() - run));
            const InstanceVertex at = rows[first + k % run];
            if (rows.is_buried(at)) continue;
            result.radiance.push_back(vertex.look_from(at) ? vertex.radiance(light, settings.depth)
                                                           : Rgb(0.0f));
        }
        result.microseconds =
            std::min(result.microseconds, 1e6 * (thread_seconds() - start) / double(result.radiance.size()));
    }
    return result;
}

}  // namespace

void study_crowd(std::size_t vertices) {
    const Scene shipped = shipped_scene().description;
    SceneEntityOptions options;
    options.fields_folder = study_fields_folder();
    double few[2] = {};
    fmt::print("{:<44} {:>12} {:>18} {:>18} {:>16} {:>10}\n", "us a vertex, one thread", "instances",
               "fields", "auto", "errors", "MB");
    const std::pair<const char*, Scene> scenes[] = {
        {"table and chairs", shipped},
        {"chairs on a floor of 40 m", crowd(shipped, 10, 20, false)},
        {"the same, each turned and scaled", crowd(shipped, 10, 20, true)},
        {"a thousand chairs there", crowd(shipped, 25, 40, false)}};
    for (const auto& [name, description] : scenes) {
        const SceneEntities entities = value_or_exit(prepare_scene_entities(description, options));
        const ShadedScene scene =
            shaded_scene(description, entities, sky_environment(*description.environment.sky, 1024));
        const Shaded found[2] = {shaded_vertices(scene, Occlusion::fields, vertices),
                                 shaded_vertices(scene, Occlusion::automatic, vertices)};
        const std::vector<Rgb> exact = shaded_vertices(scene, Occlusion::exact, vertices, 1).radiance;
        const double times[2] = {found[0].microseconds, found[1].microseconds};
        if (few[0] == 0) std::copy_n(times, 2, few);
        fmt::print(
            "{:<44} {:>12} {:>8.1f} ({:>4.1f} x) {:>8.1f} ({:>4.1f} x) {:>7.2f}% {:>6.2f}% {:>10.0f}\n", name,
            scene.instances.size(), times[0], times[0] / few[0], times[1], times[1] / few[1],
            100 * haarfield::relative_rmse(found[0].radiance, exact),
            100 * haarfield::relative_rmse(found[1].radiance, exact), resident_megabytes());
    }
}

}  // namespace haarfield::baseline
