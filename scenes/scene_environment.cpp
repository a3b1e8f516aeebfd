#include "scenes/scene_environment.h"

#include "scenes/camera_frame.h"
#include "scenes/files_in_memory.h"
#include "scenes/image.h"
#include "scenes/scene_camera.h"
#include "scenes/scene_entities.h"
#include "scenes/scene_shading.h"
#include "shading/bake/room_exposure.h"
#include "shading/scene/exposure.h"
#include "shading/scene/mixed_environment.h"
#include "shading/scene/scene_light.h"
#include "shading/scene/turned_light.h"

#include <fmt/format.h>

#include <cmath>

namespace haarfield {
namespace {

constexpr int sky_width = 1024;  // In pixels; the sun's disc covers several.

Result<Environment> read_light(const Scene& scene, const std::filesystem::path& file,
                               const std::optional<AnalyticSky>& sky, std::vector<std::string>& warnings) {
    if (sky) return sky_environment(*sky, sky_width);
    const auto given = environment_in_memory(scene, file);
    HF_TRY(LatLongImage image, given ? Result<LatLongImage>(*given) : read_environment_image(file));
    const EnvironmentFindings findings = clean_environment(image);
    if (findings.negative_values + findings.non_finite_values > 0)
        warnings.push_back(fmt::format("{}: {} negative and {} non-finite values clamped", file.string(),
                                       findings.negative_values, findings.non_finite_values));
    return Environment(std::move(image));
}

/// Returns the directions through the centres of 12 x 9 cells of the picture.
std::vector<Vec3f> picture_directions(const Camera& camera) {
    constexpr int columns = 12, rows = 9;
    const CameraFrame frame = camera_frame(camera);
    const double up = std::tan(0.5 * double(camera.vertical_fov)), across = up * camera.width / camera.height;
    std::vector<Vec3f> directions;
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column)
            directions.emplace_back(frame.forward +
                                    frame.right * (across * ((2 * column + 1.0) / columns - 1)) +
                                    frame.up * (up * (1 - (2 * row + 1.0) / rows)));
    return directions;
}

}  // namespace

Result<Environment> described_environment(const Scene& scene, std::vector<std::string>& warnings) {
    const EnvironmentDescription& description = scene.environment;
    Result<Environment> light =
        description.is_black()
            ? Result<Environment>(Environment(LatLongImage{4, 2, std::vector<Rgb>(8, Rgb(0.0f))}))
            : read_light(scene, description.image, description.sky, warnings);
    if (!light) return light;
    if (const std::optional<BlendedLight>& blend = description.blend) {
        const Result<Environment> second = read_light(scene, blend->image, blend->sky, warnings);
        if (!second) return second;
        light = mixed_environment(*light, *second, blend->share);
    }
    if (!description.lights) light = as_backdrop(*std::move(light));
    return turned_environment(*std::move(light), double(description.rotation), 0);
}

namespace {

/// Returns the place that determines the exposure: the camera's target, or the mean position of all
/// instances.
Vec3d exposed_place(const Scene& scene) {
    Vec3d place(scene.camera.target);
    if (scene.finds_camera && !scene.instances.empty()) {
        place = Vec3d(0, 0, 0);
        for (const Instance& instance : scene.instances) place += Vec3d(instance.placement.translate);
        place /= static_cast<double>(scene.instances.size());
    }
    return place;
}

/// Returns the light of a scene's emitters at a place, without shadows.
std::vector<ExposedLight> emitted_light(const ShadedScene& scene, const Vec3d& place) {
    const EmitterTree emitters = scene_emitters(scene);
    std::vector<ExposedLight> result;
    std::vector<EmitterPatch> patches;
    for (const float up : {1.0f, -1.0f}) {  // the upper and the lower hemisphere
        find_patches(emitters, Vec3f(place), Vec3f(0, up, 0), {}, patches);
        for (const EmitterPatch& patch : patches)
            result.push_back({Vec3d(patch.direction), double(luminance(patch.facing))});
    }
    return result;
}

}  // namespace

std::vector<ExposedLight> local_lights(const Scene& scene) {
    const Vec3d place = exposed_place(scene);
    std::vector<ExposedLight> local;
    for (const SceneLamp& lamp : scene.lamps) {
        const LampLight arriving = lamp_light(lamp, place);
        if (arriving.share > 0)
            local.push_back({arriving.direction, arriving.share * pi * double(luminance(lamp.colour))});
    }
    return local;
}

float found_exposure(const Scene& scene, const Environment& light) {
    return automatic_exposure(light, local_lights(scene));
}

float entity_stops(const Scene& scene, const SceneEntities& entities, const Environment& light) {
    if (scene.environment.exposure || scene.environment.is_black()) return 0;
    const ShadedScene shaded = shaded_scene(scene, entities, light);
    if (const float stops = room_exposure(shaded, picture_directions(scene_camera(scene, entities)));
        stops != 0)
        return stops;
    std::vector<ExposedLight> local = emitted_light(shaded, exposed_place(scene));
    if (local.empty()) return 0;
    const std::vector<ExposedLight> gathered = gathered_light(light), lamps = local_lights(scene);
    local.insert(local.end(), lamps.begin(), lamps.end());
    return automatic_exposure(gathered, local) - automatic_exposure(gathered, lamps);
}

Result<SceneEnvironment> scene_environment(const Scene& scene) {
    const EnvironmentDescription& description = scene.environment;
    SceneEnvironment result;
    Result<Environment> light = described_environment(scene, result.warnings);
    if (!light) return light.error();
    result.from = description.is_black() ? "none" : description.sky ? "sky" : description.image.string();
    result.is_found = !description.exposure;
    if (!is_identity(description.turn)) light = turned_environment(*light, description.turn);
    result.exposure = result.is_found ? found_exposure(scene, *light) : *description.exposure;
    result.environment = turned_environment(*std::move(light), 0, double(result.exposure));
    return result;
}

}  // namespace haarfield
