#include "tools/relight_modes.h"

#include "shading/scene/lighting.h"
#include "tools/number_option.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>

namespace haarfield {

namespace {

RelightMode spinning_light(RelightStage& stage) {
    const auto& axis = stage.options.axis;
    return {.name = "spin-light",
            .prepare = [&](const Progress& progress) { return stage.session->vary_light(progress); },
            .change =
                [&stage, axis = Vec3d(double(axis[0]), double(axis[1]), double(axis[2]))](double share) {
                    stage.rotation = rotation_about(axis, 2 * pi * share);
                    stage.session->turn_environment(stage.rotation);
                },
            .closed = true};
}

/// From one environment to the next.
RelightMode fading_lights(RelightStage& stage) {
    struct Encoded {
        std::vector<DenseCoefficients> smooth;
        std::vector<std::vector<DirectionalLight>> lights;
    };
    auto encoded = std::make_shared<Encoded>();
    const auto show_mixed = [&stage, encoded] {
        std::vector<const DenseCoefficients*> smooth;
        for (const DenseCoefficients& light : encoded->smooth) smooth.push_back(&light);
        std::vector<DirectionalLight> lights;
        for (std::size_t i = 0; i < encoded->lights.size(); ++i)
            if (stage.weights[i] > 0)
                for (const auto& [direction, irradiance] : encoded->lights[i])
                    lights.push_back({direction, irradiance * stage.weights[i]});
        stage.session->show_light(weighted_sum(smooth, stage.weights), std::move(lights));
    };
    const auto show = [&stage, encoded, show_mixed](double share) {
        const double place = share * double(encoded->smooth.size() - 1);
        for (std::size_t i = 0; i < encoded->smooth.size(); ++i)
            stage.weights[i] = static_cast<float>(std::max(0.0, 1 - std::abs(place - double(i))));
        show_mixed();
    };
    return {.name = "lights",
            .prepare = [&stage, encoded, show_mixed](const Progress& progress) -> Result<Done> {
                for (const Environment& environment : stage.environments) {
                    const SplitLight split = split_light(environment, stage.settings.sources);
                    const RgbCubemapTree light =
                        lighting_tree(split.smooth, stage.settings.face_size,
                                      {stage.settings.light_coefficients}, progress.stop);
                    if (progress.stop.stop_requested()) return Error{"", interrupted};
                    encoded->smooth.push_back(dense_coefficients(light, stage.settings.face_size));
                    encoded->lights.push_back(all_lights(split.sources));
                }
                // The vectors are pruned for all of them.
                std::ranges::fill(stage.weights, 1 / static_cast<float>(encoded->smooth.size()));
                show_mixed();
                return stage.session->vary_light(progress);
            },
            .change = show};
}

/// Round the target, seen from above counter-clockwise.
RelightMode orbiting_eye(RelightStage& stage) {
    return {.name = "orbit",
            .prepare = [&](const Progress& progress) { return stage.session->vary_eye(progress); },
            .change =
                [&stage, start = stage.scene.camera.position](double share) {
                    Camera& camera = stage.scene.camera;
                    camera.position =
                        camera.target + rotation_about({0, 1, 0}, 2 * pi * share)(start - camera.target);
                    stage.session->set_eye(camera.position);
                },
            .closed = true,
            .by_vertex = true};
}

/// Along a path of straight lines, at an even pace.
RelightMode moving_instance(RelightStage& stage, std::size_t instance, std::vector<Vec3f> path) {
    return {
        .name = "move",
        .prepare = [&stage, instance](
                       const Progress& progress) { return stage.session->vary_instance(instance, progress); },
        .change =
            [&stage, instance, path = std::move(path)](double share) {
                float length = 0;
                for (std::size_t i = 1; i < path.size(); ++i) length += (path[i] - path[i - 1]).length();
                float left = static_cast<float>(share) * length;
                std::size_t i = 1;
                while (i + 1 < path.size() && left > (path[i] - path[i - 1]).length())
                    left -= (path[i] - path[i - 1]).length(), ++i;
                const Vec3f step = path[i] - path[i - 1];
                const float along = step.length() > 0 ? std::min(1.0f, left / step.length()) : 0;
                Placement& moving = stage.scene.instances[instance].placement;
                moving.translate = path[i - 1] + step * along;
                stage.session->place(instance, moving);
            },
        .rests = true};
}

Result<RelightMode> moving_instance(RelightStage& stage) {
    const std::string& name = stage.options.move[0];
    const auto& instances = stage.scene.instances;
    const auto instance = std::ranges::find(instances, name, &Instance::name);
    if (instance == instances.end()) {
        std::string names;
        for (const Instance& other : instances) names += (names.empty() ? "" : ", ") + other.name;
        return Error{"--move", fmt::format("there is no instance {}; wanted one of {}", name, names)};
    }
    std::vector<Vec3f> path{instance->placement.translate};
    const std::optional<std::vector<Vec3f>> points = path_points(stage.options.move[1]);
    assert(points);
    path.insert(path.end(), points->begin(), points->end());
    return moving_instance(stage, static_cast<std::size_t>(instance - instances.begin()), std::move(path));
}

}  // namespace

std::optional<std::vector<Vec3f>> path_points(std::string_view text) {
    std::vector<Vec3f> points;
    for (std::size_t first = 0; first <= text.size();) {
        const std::size_t end = std::min(text.find(':', first), text.size());
        const std::optional<Vec3f> point = place_in(text.substr(first, end - first));
        if (!point) return std::nullopt;
        points.push_back(*point);
        first = end + 1;
    }
    return points;
}

Rgb RelightStage::background(const Vec3f& direction) const {
    const Vec3d before = rotation.inverse()(Vec3d(direction));
    Rgb sum(0.0f);
    for (std::size_t i = 0; i < environments.size(); ++i)
        if (weights[i] > 0) sum += radiance_from(backgrounds[i], before) * weights[i];
    return sum;
}

Result<RelightMode> chosen_mode(RelightStage& stage) {
    if (stage.options.spin_light) return spinning_light(stage);
    if (!stage.options.lights.empty()) return fading_lights(stage);
    if (stage.options.orbit) return orbiting_eye(stage);
    return moving_instance(stage);
}

}  // namespace haarfield
