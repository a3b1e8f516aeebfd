#include <fmt/format.h>

#include <cstdlib>
#include <ctime>
#include <functional>

#include "bridge/pictures/image_difference.h"
#include "bridge/pictures/preview.h"
#include "scenes/scene_entities.h"
#include "scenes/scene_reader.h"
#include "scenes/scene_shading.h"
#include "shading/bake/colour_fit.h"
#include "shading/bake/mesh_refinement.h"
#include "shading/scene/lighting.h"
#include "tests/studies/study.h"

namespace haarfield::baseline {
namespace {

template <class T>
T value_or_exit(Result<T> result) {
    if (result) return std::move(*result);
    fmt::print(stderr, "{}\n", result.error().message());
    std::exit(1);
}

/// The shipped scene with its fields, ready to be shaded at any point.
struct LitScene {
    Scene description;
    SceneEntities entities;
    ShadedScene scene;
    RenderSettings settings;
    ShadingGeometry geometry;
    SceneLight light;
    PointShading shading{scene, geometry, light, settings};

    explicit LitScene(const MeshStudyOptions& options)
        : description(value_or_exit(read_scene(HAARFIELD_SOURCE_DIR "/scenes/table_and_chairs.toml"))),
          entities(value_or_exit(prepare_scene_entities(description, fields_in(options.fields)))),
          scene(shaded_scene(description, entities, environment(options))),
          geometry(value_or_exit(shading_geometry(scene, settings))),
          light(scene_light(scene.environment, settings)) {}

    static SceneEntityOptions fields_in(const std::string& folder) {
        SceneEntityOptions options;
        options.fields_folder = folder;
        return options;
    }

    Environment environment(const MeshStudyOptions& options) const {
        Environment distant = options.environment.empty()
                                  ? sky_environment(*description.environment.sky, 1024)
                                  : Environment(value_or_exit(read_environment_image(options.environment)));
        clean_environment(distant.image);
        return turned_environment(distant, description.environment.rotation, options.exposure);
    }

    std::vector<RadiantMesh> even(std::size_t vertices) const {
        return value_or_exit(mesh_radiance(shading, surface_meshes(entities, vertices)));
    }
    std::vector<RadiantMesh> refined(std::size_t vertices) const {
        const float until_budget = 1e-4f;
        return value_or_exit(
                   refined_radiance(shading, {until_budget, vertices}, even(vertices / refinement_share)))
            .meshes;
    }
    std::vector<RadiantMesh> fitted(std::vector<RadiantMesh> meshes) const {
        value_or_exit(fit_radiance(shading, meshes));
        return meshes;
    }

    Image picture(const std::vector<RadiantMesh>& meshes) const {
        SceneRadiance radiance;
        for (const RadiantMesh& mesh : meshes) radiance.push_back(mesh.radiance);
        const SceneColours colours = total(radiance);
        std::vector<BakedInstance> instances;
        for (std::size_t i = 0; i < meshes.size(); ++i)
            instances.push_back({"", &meshes[i].mesh, description.instances[i].placement, colours[i]});
        return Preview().draw(description.camera, instances, [](const Vec3f&) { return Rgb(0.0f); });
    }
};

}  // namespace

std::vector<PlotPanel> study_meshes(std::size_t vertices, const MeshStudyOptions& options) {
    const LitScene lit(options);
    using Meshes = std::vector<RadiantMesh>;
    struct Way {
        const char* name;
        std::function<Meshes(std::size_t)> meshes;
        bool dashed;
        int colour;
    };
    const std::vector<Way> ways{
        {"even", [&](std::size_t count) { return lit.even(count); }, false, 1},
        {"even, fitted", [&](std::size_t count) { return lit.fitted(lit.even(count)); }, true, 1},
        {"refined", [&](std::size_t count) { return lit.refined(count); }, false, 2},
        {"refined, fitted", [&](std::size_t count) { return lit.fitted(lit.refined(count)); }, true, 2}};
    const Image reference = options.reference.empty() ? lit.picture(lit.even(4 * vertices))
                                                      : value_or_exit(read_image(options.reference));

    fmt::print("The shipped scene against {}; the background left out.\n\n",
               options.reference.empty() ? "an even mesh of four times the vertices" : options.reference);
    fmt::print("{:<16} {:>9} {:>9} {:>9} {:>15}\n", "mesh", "vertices", "CPU s", "PSNR dB", "relative RMSE");
    std::vector<PlotSeries> quality, time;
    for (const Way& way : ways) {
        quality.push_back({way.name, {}, way.colour, way.dashed});
        time.push_back({way.name, {}, way.colour, way.dashed});
        for (std::size_t count = vertices; count > 0 && count >= vertices / 16; count /= 2) {
            const std::clock_t start = std::clock();
            const Meshes meshes = way.meshes(count);
            const double seconds = double(std::clock() - start) / CLOCKS_PER_SEC;
            std::size_t found = 0;
            for (const RadiantMesh& mesh : meshes) found += mesh.radiance.size();
            const ImageDifference difference =
                value_or_exit(image_difference(lit.picture(meshes), reference));
            fmt::print("{:<16} {:>9} {:>9.1f} {:>9.2f} {:>13.2f} %\n", way.name, found, seconds,
                       difference.psnr_db, 100 * difference.relative_rmse);
            quality.back().points.emplace_back(double(found), difference.psnr_db);
            time.back().points.emplace_back(seconds, difference.psnr_db);
        }
    }
    const PlotAxis psnr{"PSNR, dB", false, {32, 34, 36, 38, 40, 42}};
    return {{"Quality", {"vertices", true, {1e4, 2e4, 5e4, 1e5, 2e5}}, psnr, quality},
            {"Cost", {"CPU time of shading, s", true, {}}, psnr, time}};
}

}  // namespace haarfield::baseline
