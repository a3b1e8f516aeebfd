#include "scenes/scene_environment.h"

#include "scenes/given_files.h"
#include "scenes/image.h"
#include "shading/scene/exposure.h"

#include <fmt/format.h>

namespace haarfield {
namespace {

constexpr int sky_width = 1024;  // pixels; the sun's disc is spread over those that it covers

Result<Environment> unexposed_environment(const Scene& scene, std::vector<std::string>& warnings) {
    const EnvironmentDescription& description = scene.environment;
    if (description.sky) return sky_environment(*description.sky, sky_width);
    const auto given = given_environment(scene, description.image);
    Result<LatLongImage> image =
        given ? Result<LatLongImage>(*given) : read_environment_image(description.image);
    if (!image) return image.error();
    const EnvironmentFindings findings = clean_environment(*image);
    if (findings.negative_values + findings.non_finite_values > 0)
        warnings.push_back(fmt::format("{}: {} negative and {} non-finite values clamped",
                                       description.image.string(), findings.negative_values,
                                       findings.non_finite_values));
    return Environment(std::move(*image));
}

}  // namespace

Result<SceneEnvironment> scene_environment(const Scene& scene) {
    const EnvironmentDescription& description = scene.environment;
    SceneEnvironment result;
    const Result<Environment> light = unexposed_environment(scene, result.warnings);
    if (!light) return light.error();
    result.from = description.sky ? "sky" : description.image.string();
    result.is_found = !description.exposure;
    result.exposure = result.is_found ? automatic_exposure(*light) : *description.exposure;
    result.environment = turned_environment(*light, double(description.rotation), double(result.exposure));
    return result;
}

}  // namespace haarfield
