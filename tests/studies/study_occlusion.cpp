#include <fmt/format.h>

#include <cmath>

#include "scenes/scene_reader.h"
#include "scenes/scene_shading.h"
#include "shading/bake/dense_renderer.h"
#include "shading/scene/lighting.h"
#include "tests/baselines/product_methods.h"
#include "tests/studies/study.h"
#include "tools/stopwatch.h"

namespace haarfield::baseline {
namespace {

double relative_rmse(const SceneColours& found, const SceneColours& wanted) {
    double difference = 0, norm = 0;
    for (std::size_t i = 0; i < wanted.size(); ++i)
        for (std::size_t v = 0; v < wanted[i].size(); ++v) {
            difference += Vec3d(found[i][v] - wanted[i][v]).length2();
            norm += Vec3d(wanted[i][v]).length2();
        }
    return std::sqrt(difference / norm);
}

}  // namespace

void study_occlusion(const std::string& file, std::size_t vertices) {
    const Scene description = with_vertices(value_or_exit(read_scene(file)), vertices);
    SceneEntityOptions options;
    options.fields_folder = study_fields_folder();
    const SceneEntities entities = value_or_exit(prepare_scene_entities(description, options));
    const ShadedScene scene =
        shaded_scene(description, entities, sky_environment(*description.environment.sky, 1024));

    RenderSettings settings;
    const SceneColours dense = total(value_or_exit(dense_scene_radiance(scene, settings)));
    std::size_t count = 0;
    for (const auto& instance : dense) count += instance.size();
    fmt::print("{}: {} vertices, against the dense oracle.\n\n", file, count);
    fmt::print("{:<44} {:>14} {:>14}\n", "occlusion", "CPU us a vertex", "relative RMSE");
    const auto show = [&](const std::string& title, Occlusion occlusion, float error, int light_wavelets) {
        settings.occlusion = occlusion;
        settings.occlusion_error = error;
        const ShadingGeometry geometry = value_or_exit(shading_geometry(scene, settings));
        settings.light_coefficients = light_wavelets;
        const SceneLight light = scene_light(scene.environment, settings);
        double least = INFINITY;
        SceneColours radiance;
        for (int round = 0; round < 3; ++round) {
            const Stopwatch watch;
            radiance = total(value_or_exit(scene_radiance({scene, geometry, light, settings})));
            least = std::min(least, watch.elapsed().processor);
        }
        fmt::print("{:<44} {:>14.1f} {:>12.2f} %\n", title, 1e6 * least / double(count),
                   100 * relative_rmse(radiance, dense));
    };
    const int kept = settings.light_coefficients;
    show("fields", Occlusion::fields, 0, kept);
    for (const float error : {0.2f, 0.1f, 0.05f, 0.02f, 0.01f})
        show(fmt::format("auto, error above {}", error), Occlusion::automatic, error, kept);
    show("exact", Occlusion::exact, 0, kept);
    show("exact, all wavelets of the lighting", Occlusion::exact, 0, 0);
}

}  // namespace haarfield::baseline
