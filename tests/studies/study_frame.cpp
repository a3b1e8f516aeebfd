#include <fmt/format.h>

#include <chrono>
#include <cmath>

#include "shading/scene/lighting.h"
#include "tests/baselines/product_methods.h"
#include "tests/studies/study.h"

namespace haarfield::baseline {
namespace {

/// Least wall time of three runs. [ms]
template <class Work>
double least_milliseconds(const Work& work) {
    double least = INFINITY;
    for (int round = 0; round < 3; ++round) {
        const auto start = std::chrono::steady_clock::now();
        work();
        const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - start;
        least = std::min(least, taken.count());
    }
    return least;
}

}  // namespace

void study_frame(std::size_t vertices) {
    const Scene description = with_vertices(shipped_scene().description, vertices);
    SceneEntityOptions options;
    options.fields_folder = study_fields_folder();
    const SceneEntities entities = value_or_exit(prepare_scene_entities(description, options));
    ShadedScene scene =
        shaded_scene(description, entities, sky_environment(*description.environment.sky, 1024));
    std::size_t count = 0;
    for (const ShadedInstance& instance : scene.instances)
        count += scene.entities[instance.entity].mesh->positions.size();

    fmt::print("{}: {} vertices, all threads, least of three.\n\n{:<44} {:>10}\n", description.name, count,
               "", "ms");
    RenderSettings settings;
    const auto encoded = [&] { return scene_light(scene.environment, settings); };
    fmt::print("{:<44} {:>10.0f}\n", "encoding 1024 x 512 pixels of light",
               least_milliseconds([&] { encoded(); }));
    const SceneLight light = encoded();
    const auto print_frames = [&](const ShadingGeometry& geometry, const KeptVisibility* kept) {
        for (const int depth : {full_depth, 5, 4, 3, 2}) {
            settings.depth = depth;
            fmt::print("{:<44} {:>10.0f}\n",
                       depth == full_depth ? std::string("  new light and view")
                                           : fmt::format("    at depth {}", depth),
                       least_milliseconds([&] {
                           scene.eye += Vec3f(0.01f, 0, 0);
                           value_or_exit(scene_radiance({scene, geometry, light, settings, kept}));
                       }));
        }
        settings.depth = full_depth;
    };
    for (const auto& [name, occlusion] :
         {std::pair("fields", Occlusion::fields), std::pair("auto", Occlusion::automatic)}) {
        settings.occlusion = occlusion;
        const auto geometry = [&] { return value_or_exit(shading_geometry(scene, settings)); };
        fmt::print("{:<44} {:>10.0f}\n", fmt::format("--occlusion {}: preparing, once a scene", name),
                   least_milliseconds(geometry));
        const ShadingGeometry prepared = geometry();
        print_frames(prepared, nullptr);
        const auto keep = [&] {
            return value_or_exit(KeptVisibility::make(scene, prepared, settings.kept_bytes));
        };
        const double milliseconds = least_milliseconds(keep);
        const KeptVisibility kept = keep();
        fmt::print("{:<44} {:>10.0f}\n",
                   fmt::format("  keeping what vertices see, {:.0f} MB", 1e-6 * double(kept.bytes())),
                   milliseconds);
        print_frames(prepared, &kept);
    }
}

}  // namespace haarfield::baseline
