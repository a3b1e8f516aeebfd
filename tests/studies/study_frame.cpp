#include <fmt/format.h>

#include <cmath>

#include "scenes/scene_shading.h"
#include "shading/scene/lighting.h"
#include "tests/baselines/product_methods.h"
#include "tests/studies/study.h"
#include "tools/stopwatch.h"

namespace haarfield::baseline {
namespace {

/// Prints the wall time and the busy cores of the fastest of three runs.
template <class Work>
void print_least(const std::string& title, const Work& work) {
    RunTime least{INFINITY, 0};
    for (int round = 0; round < 3; ++round) {
        const Stopwatch watch;
        work();
        if (const RunTime time = watch.elapsed(); time.wall < least.wall) least = time;
    }
    fmt::print("{:<44} {:>10.0f} {:>10.2f}\n", title, 1e3 * least.wall, least.processor / least.wall);
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

    fmt::print("{}: {} vertices, all threads, least of three.\n\n{:<44} {:>10} {:>10}\n", description.name,
               count, "", "ms", "cores");
    RenderSettings settings;
    const auto encoded = [&] { return scene_light(scene.environment, settings); };
    print_least("encoding 1024 x 512 pixels of light", [&] { encoded(); });
    const SceneLight light = encoded();
    const auto print_frames = [&](const ShadingGeometry& geometry, const CachedVisibility* kept) {
        for (const int depth : {full_depth, 5, 4, 3, 2}) {
            settings.depth = depth;
            print_least(depth == full_depth ? "  new light and view" : fmt::format("    at depth {}", depth),
                        [&] {
                            scene.eye += Vec3f(0.01f, 0, 0);
                            total(value_or_exit(scene_radiance({scene, geometry, light, settings, kept})));
                        });
        }
        settings.depth = full_depth;
    };
    for (const auto& [name, occlusion] :
         {std::pair("fields", Occlusion::fields), std::pair("auto", Occlusion::automatic)}) {
        settings.occlusion = occlusion;
        const auto geometry = [&] { return value_or_exit(shading_geometry(scene, settings)); };
        print_least(fmt::format("--occlusion {}: preparing, once a scene", name), geometry);
        const ShadingGeometry prepared = geometry();
        print_frames(prepared, nullptr);
        const auto keep = [&] {
            return value_or_exit(CachedVisibility::make(scene, prepared, settings.kept_bytes));
        };
        const CachedVisibility kept = keep();
        print_least(fmt::format("  keeping what vertices see, {:.0f} MB", 1e-6 * double(kept.bytes())), keep);
        print_frames(prepared, &kept);
    }
}

}  // namespace haarfield::baseline
