#include "tools/relight_modes.h"

#include "shading/scene/lighting.h"
#include "tools/number_option.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <span>

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

/// Fades from each environment to the next.
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
                    if (progress.stop.stop_requested()) return interruption();
                    encoded->smooth.push_back(dense_coefficients(light, stage.settings.face_size));
                    encoded->lights.push_back(all_lights(split.sources));
                }
                // The vectors are pruned for all environments.
                std::ranges::fill(stage.weights, 1 / static_cast<float>(encoded->smooth.size()));
                show_mixed();
                return stage.session->vary_light(progress);
            },
            .change = show};
}

/// Orbits the target, counter-clockwise as viewed from above.
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

/// A value at a time. The film lasts from 0 to 1.
struct Stop {
    double time;
    Vec3f value;
};

/// Interpolates linearly between stops in the order of their times; constant before the first and after the
/// last.
Vec3f value_at(std::span<const Stop> stops, double time) {
    const auto next = std::ranges::find_if(stops, [time](const Stop& stop) { return stop.time >= time; });
    if (next == stops.end()) return stops.back().value;
    if (next == stops.begin()) return next->value;
    const Stop& last = next[-1];
    const double share = (time - last.time) / (next->time - last.time);
    return last.value + (next->value - last.value) * static_cast<float>(share);
}

/// The motion of an instance.
struct Motion {
    std::size_t instance;
    Placement start;
    std::vector<Stop> places;  ///< Positions, starting with that of the start. [m]
    /// Rotations relative to the start, as angles of rotation_xyz; empty if the instance never turns. [rad]
    std::vector<Stop> turns{};
    std::vector<Stop> sizes{};  ///< Scale relative to the start, in all three components; empty if constant.

    Placement at(double time) const {
        Placement placement = start;
        placement.translate = value_at(places, time);
        if (!turns.empty()) placement.rotate = rotation_xyz(value_at(turns, time)) * start.rotate;
        if (!sizes.empty()) placement.scale = start.scale * value_at(sizes, time).x;
        return placement;
    }
};

/// Returns stops on straight lines with constant speed.
std::vector<Stop> even_pace(std::span<const Vec3f> path) {
    std::vector<Stop> stops;
    double length = 0;
    for (std::size_t i = 0; i < path.size(); ++i) {
        if (i > 0) length += double((path[i] - path[i - 1]).length());
        stops.push_back({length, path[i]});
    }
    if (length > 0)
        for (Stop& stop : stops) stop.time /= length;
    return stops;
}

void place(RelightStage& stage, const Motion& motion, double share) {
    Placement& placement = stage.scene.instances[motion.instance].placement;
    placement = motion.at(share);
    stage.session->place(motion.instance, placement);
}

/// Moves an instance without rotation, with transfer vectors that follow it.
RelightMode moving_instance(RelightStage& stage, Motion motion) {
    return {
        .name = "move",
        .prepare = [&stage, instance = motion.instance](
                       const Progress& progress) { return stage.session->vary_instance(instance, progress); },
        .change = [&stage, motion = std::move(motion)](double share) { place(stage, motion, share); },
        .rests = true};
}

RelightMode moving_instances(RelightStage& stage, std::vector<Motion> motions) {
    return {.name = "move",
            .prepare = [](const Progress&) -> Result<Done> { return Done{}; },
            .change =
                [&stage, motions = std::move(motions)](double share) {
                    for (const Motion& motion : motions) place(stage, motion, share);
                },
            .in_full = true};
}

Result<std::size_t> instance_named(const std::string& name, const char* option, const RelightStage& stage) {
    const auto& instances = stage.scene.instances;
    const auto instance = std::ranges::find(instances, name, &Instance::name);
    if (instance != instances.end()) return static_cast<std::size_t>(instance - instances.begin());
    std::string names;
    for (const Instance& other : instances) names += (names.empty() ? "" : ", ") + other.name;
    return Error{option, fmt::format("unknown instance {}; expected one of {}", name, names)};
}

/// Returns the motion of an instance; adds one if there is none.
Motion& motion_of(std::size_t instance, std::vector<Motion>& motions, const RelightStage& stage) {
    const auto known = std::ranges::find(motions, instance, &Motion::instance);
    if (known != motions.end()) return *known;
    const Placement& start = stage.scene.instances[instance].placement;
    motions.push_back({instance, start, {Stop{0, start.translate}}});
    return motions.back();
}

/// Returns the motions of --move and --rotate.
Result<std::vector<Motion>> asked_motions(const RelightStage& stage) {
    std::vector<Motion> motions;
    const auto given_twice = [](const char* option, const std::string& name) {
        return Error{option, fmt::format("names {} twice; expected each instance at most once", name)};
    };
    for (const auto& [name, text] : stage.options.moves) {
        HF_TRY(const std::size_t instance, instance_named(name, "--move", stage));
        Motion& motion = motion_of(instance, motions, stage);
        if (motion.places.size() > 1) return given_twice("--move", name);
        std::optional<std::vector<Vec3f>> path = path_points(text);
        assert(path);
        path->insert(path->begin(), motion.start.translate);
        motion.places = even_pace(*path);
    }
    for (const auto& [name, text] : stage.options.turns) {
        HF_TRY(const std::size_t instance, instance_named(name, "--rotate", stage));
        Motion& motion = motion_of(instance, motions, stage);
        if (!motion.turns.empty()) return given_twice("--rotate", name);
        const std::optional<Vec3f> degrees = place_in(text);
        assert(degrees);
        motion.turns = {{0, Vec3f(0, 0, 0)}, {1, *degrees * static_cast<float>(pi / 180)}};
    }
    return motions;
}

/// Returns the time of the scene's last keyframe; 0 without keyframes. [s]
double film_seconds(const Scene& scene) {
    double last = 0;
    for (const Keyframe& keyframe : scene.keyframes) last = std::max(last, double(keyframe.time));
    for (const LampKeyframe& keyframe : scene.lamp_keyframes) last = std::max(last, double(keyframe.time));
    return last;
}

/// Adds a keyframe's value. A keyframe at time 0 replaces the start.
void add_stop(std::vector<Stop>& stops, double time, const Vec3f& value) {
    if (!(time > 0)) stops.clear();
    stops.push_back({time, value});
}

/// Returns the motions of the scene's keyframes.
Result<std::vector<Motion>> keyframe_motions(const RelightStage& stage) {
    const double last = film_seconds(stage.scene);
    if (!(last > 0)) return Error{"--keyframes", "the scene has no [[keyframes]] after time 0"};
    std::vector<Motion> motions;
    const auto add = [last](std::vector<Stop>& stops, double time, const Vec3f& value) {
        add_stop(stops, time / last, value);
    };
    for (const Keyframe& keyframe : stage.scene.keyframes) {
        Motion& motion = motion_of(keyframe.instance, motions, stage);
        if (keyframe.translate) add(motion.places, double(keyframe.time), *keyframe.translate);
        if (keyframe.rotate) {
            if (motion.turns.empty()) motion.turns = {{0, Vec3f(0, 0, 0)}};
            add(motion.turns, double(keyframe.time), *keyframe.rotate);
        }
        if (keyframe.scale) {
            if (motion.sizes.empty()) motion.sizes = {{0, Vec3f(1, 1, 1)}};
            add(motion.sizes, double(keyframe.time), Vec3f(*keyframe.scale));
        }
    }
    return motions;
}

/// The changes of a lamp.
struct LampChange {
    std::size_t lamp;
    std::vector<Stop> positions, targets, colours;
};

/// Returns the changes of lamps by the scene's keyframes.
std::vector<LampChange> lamp_changes(const Scene& scene) {
    const double last = film_seconds(scene);
    std::vector<LampChange> changes;
    for (const LampKeyframe& keyframe : scene.lamp_keyframes) {
        auto change = std::ranges::find(changes, keyframe.lamp, &LampChange::lamp);
        if (change == changes.end()) {
            const Lamp& start = scene.lamps[keyframe.lamp];
            changes.push_back(
                {keyframe.lamp, {{0, start.position}}, {{0, start.target}}, {{0, Vec3f(start.colour)}}});
            change = changes.end() - 1;
        }
        const double time = double(keyframe.time) / last;
        if (keyframe.position) add_stop(change->positions, time, *keyframe.position);
        if (keyframe.target) add_stop(change->targets, time, *keyframe.target);
        if (keyframe.colour) add_stop(change->colours, time, *keyframe.colour);
    }
    return changes;
}

void change_lamps(RelightStage& stage, std::span<const LampChange> changes, double time) {
    for (const LampChange& change : changes) {
        Lamp& lamp = stage.scene.lamps[change.lamp];
        lamp.position = value_at(change.positions, time);
        lamp.target = value_at(change.targets, time);
        lamp.colour = Rgb(value_at(change.colours, time));
    }
    stage.session->set_lamps(lamps_of(stage.scene.lamps));
}

RelightMode changing_lamps(RelightStage& stage, std::vector<LampChange> changes) {
    return {.name = "lamps",
            .prepare = [&stage](const Progress& progress) { return stage.session->vary_lamps(progress); },
            .change = [&stage,
                       changes = std::move(changes)](double share) { change_lamps(stage, changes, share); }};
}

Result<RelightMode> moving_instances(RelightStage& stage) {
    HF_TRY(std::vector<Motion> motions,
           stage.options.keyframes ? keyframe_motions(stage) : asked_motions(stage));
    if (stage.options.keyframes && !stage.scene.lamp_keyframes.empty()) {
        std::vector<LampChange> changes = lamp_changes(stage.scene);
        if (motions.empty()) return changing_lamps(stage, std::move(changes));
        RelightMode mode = moving_instances(stage, std::move(motions));
        mode.change = [&stage, move = std::move(mode.change), changes = std::move(changes)](double share) {
            move(share);
            change_lamps(stage, changes, share);
        };
        return mode;
    }
    if (motions.size() == 1 && motions.front().turns.empty())
        return moving_instance(stage, std::move(motions.front()));
    return moving_instances(stage, std::move(motions));
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
    return moving_instances(stage);
}

}  // namespace haarfield
