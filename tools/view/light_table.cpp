#include "tools/view/light_table.h"

#include "fields/wavelets/haar_transform.h"
#include "scenes/scene_environment.h"
#include "shading/scene/exposure.h"
#include "shading/scene/mixed_environment.h"

#include <fmt/format.h>

#include <algorithm>

namespace haarfield {
namespace {

constexpr std::size_t most_known = 4;   ///< Cached lights, of about 2 MB each and the image.
constexpr int lights_while_moving = 4;  ///< Per source.

/// Returns a key that identifies a light.
std::string light_key(const std::filesystem::path& image, const std::optional<AnalyticSky>& sky) {
    if (!sky) return "image " + image.string();
    return fmt::format("sky {} {} {} {} {} {} {}", sky->turbidity, sky->sun_elevation, sky->sun_azimuth,
                       sky->sun_angular_radius, sky->ground.x, sky->ground.y, sky->ground.z);
}

}  // namespace

Result<std::shared_ptr<const EncodedLight>> LightTable::encoded(const std::filesystem::path& image,
                                                                const std::optional<AnalyticSky>& sky) {
    const std::string key = light_key(image, sky);
    const auto known = std::ranges::find(known_, key, [](const auto& light) { return light.first; });
    if (known != known_.end()) {
        std::rotate(known, known + 1, known_.end());
        return known_.back().second;
    }
    Scene scene;
    scene.environment.image = image;
    scene.environment.sky = sky;
    std::vector<std::string> ignored;
    HF_TRY(Environment read, described_environment(scene, ignored));
    auto light = std::make_shared<EncodedLight>();
    SplitLight split = split_light(read, settings_.sources);
    light->smooth = turnable_light(split.smooth, settings_.face_size);
    light->sources = std::move(split.sources);
    light->gathered = gathered_light(read);
    light->automatic_exposure = automatic_exposure(light->gathered, {});
    light->environment = std::move(read);
    if (known_.size() == most_known) known_.erase(known_.begin());
    known_.emplace_back(key, light);
    return std::shared_ptr<const EncodedLight>(light);
}

Result<Done> LightTable::know(const EnvironmentDescription& light) {
    HF_TRY_DONE(encoded(light.image, light.sky));
    if (light.blend) HF_TRY_DONE(encoded(light.blend->image, light.blend->sky));
    return Done{};
}

Result<Done> LightTable::take(const Design& design) {
    if (taken_ == design.light_stamp) return Done{};
    const EnvironmentDescription& environment = design.scene.environment;
    HF_TRY(std::shared_ptr<const EncodedLight> first, encoded(environment.image, environment.sky));
    std::shared_ptr<const EncodedLight> other;
    if (environment.blend) {
        HF_TRY(std::shared_ptr<const EncodedLight> second,
               encoded(environment.blend->image, environment.blend->sky));
        other = second;
    }
    first_ = first;
    second_ = std::move(other);
    taken_ = design.light_stamp;
    mixed_.reset();
    return Done{};
}

GivenLight LightTable::momentary(const Design& design, bool few) const {
    const Rotation& turn = design.scene.environment.turn;
    const float share = second_share(design);
    std::vector<Rgb> texels;
    std::vector<DirectionalLight> lights;
    for (const auto& [light, of] : {std::pair(first_.get(), 1 - share), std::pair(second_.get(), share)}) {
        if (!light || of <= 0) continue;
        std::vector<Rgb> turned = turned_lighting_texels(light->smooth, turn);
        if (of < 1)
            for (Rgb& texel : turned) texel *= of;
        if (texels.empty())
            texels = std::move(turned);
        else
            std::ranges::transform(texels, turned, texels.begin(), std::plus<>());
        for (const LightSource& source : light->sources) {
            std::vector<DirectionalLight> of_source = source.lights;
            if (few) of_source = reduced_lights(of_source, lights_while_moving);
            for (const DirectionalLight& one : of_source)
                lights.push_back({turn(one.direction), one.irradiance * of});
        }
    }
    const RgbCubemapTree tree =
        haar_cubemap<Rgb>(texels, settings_.face_size, Truncation{settings_.light_coefficients});
    return {dense_coefficients(tree, settings_.face_size), std::move(lights)};
}

const Environment& LightTable::mixed(const Design& design) {
    const float share = second_share(design);
    if (!second_ || share <= 0) return first_->environment;
    if (!mixed_ || mixed_share_ != share) {
        mixed_ = mixed_environment(first_->environment, second_->environment, share);
        mixed_share_ = share;
    }
    return *mixed_;
}

float LightTable::exposure(const Design& design) const {
    const std::optional<float>& given = design.scene.environment.exposure;
    if (given) return *given;
    if (!first_) return 0;
    const float share = second_ ? second_share(design) : 0;
    if (share <= 0 && design.scene.lamps.empty()) return first_->automatic_exposure;
    std::vector<ExposedLight> distant;
    for (const auto& [light, of] : {std::pair(first_.get(), 1 - share), std::pair(second_.get(), share)}) {
        if (!light || of <= 0) continue;
        for (const ExposedLight& one : light->gathered)
            distant.push_back({design.scene.environment.turn(one.direction), one.irradiance * double(of)});
    }
    return automatic_exposure(distant, local_lights(design.scene));
}

}  // namespace haarfield
