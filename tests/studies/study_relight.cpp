#include <fmt/format.h>

#include <chrono>
#include <cmath>

#include "scenes/scene_environment.h"
#include "scenes/scene_reader.h"
#include "scenes/scene_shading.h"
#include "shading/transfer/relight_session.h"
#include "tests/baselines/scene_integrals.h"
#include "tests/studies/study.h"

namespace haarfield::baseline {
namespace {

using Clock = std::chrono::steady_clock;

double milliseconds_since(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// Returns the RMS of the difference / RMS of the expected values.
double difference(const SceneColours& found, const SceneColours& wanted) {
    double error = 0, whole = 0;
    for (std::size_t i = 0; i < wanted.size(); ++i)
        for (std::size_t v = 0; v < wanted[i].size(); ++v) {
            error += double(squared(found[i][v] - wanted[i][v]));
            whole += double(squared(wanted[i][v]));
        }
    return std::sqrt(error / whole);
}

struct Kind {
    const char* name;
    std::function<Result<Done>(RelightSession&)> vary;
    std::function<void(RelightSession&, double share)> change;
};

/// Measures frames, and compares some of them with a commit of the same scene.
void print_frames(RelightSession& session, const Kind& kind, FrameQuality quality) {
    constexpr int frames = 12, compared = 4;
    Clock::time_point start = Clock::now();
    value_or_exit(kind.vary(session));
    const double vectors = milliseconds_since(start);
    double least = INFINITY, error = 0;
    for (int i = 0; i < frames; ++i) {
        kind.change(session, double(i) / frames);
        start = Clock::now();
        value_or_exit(session.frame(quality));
        least = std::min(least, milliseconds_since(start));
        if (i % (frames / compared) != 1) continue;
        const SceneColours found = session.radiance();
        value_or_exit(session.commit());
        error = std::max(error, difference(found, session.radiance()));
    }
    fmt::print("{:<16} {:<8} {:>10.0f} {:>10.1f} {:>12.4f}\n", kind.name,
               quality == FrameQuality::still ? "still" : "moving", vectors, least, error);
    std::fflush(stdout);
}

}  // namespace

void study_relight(const std::string& file, std::size_t vertices, const std::string& environment) {
    Scene description = value_or_exit(read_scene(file));
    if (!environment.empty()) {
        description.environment = {};
        description.environment.image = environment;
    }
    description = with_vertices(std::move(description), vertices);
    SceneEntityOptions options;
    options.fields_folder = study_fields_folder();
    const SceneEntities entities = value_or_exit(prepare_scene_entities(description, options));
    const ShadedScene scene =
        shaded_scene(description, entities, value_or_exit(scene_environment(description)).environment);
    const SplitLight split = split_light(scene.environment);
    fmt::print("{}: {} concentrated sources of {} lights, all threads\n", description.name,
               split.sources.size(), all_lights(split.sources).size());
    std::size_t chair = 0;
    for (std::size_t i = 0; i < description.instances.size(); ++i)
        if (description.entities[description.instances[i].entity].name == "chair") chair = i;
    const Placement stands = scene.instances[chair].placement;
    const Kind kinds[] = {
        {"light turns", [](RelightSession& session) { return session.vary_light(); },
         [](RelightSession& session, double share) {
             session.turn_environment(rotation_about({0, 1, 0}, 2 * pi * share));
         }},
        {"eye moves", [](RelightSession& session) { return session.vary_eye(); },
         [](RelightSession& session, double share) {
             session.set_eye(Vec3f(Vec3d(2.5 * std::cos(6 * share), 1.5, 2.5 * std::sin(6 * share))));
         }},
        {"chair is moved", [=](RelightSession& session) { return session.vary_instance(chair); },
         [=](RelightSession& session, double share) {
             Placement placement = stands;
             placement.translate.x += static_cast<float>(0.5 * share);
             session.place(chair, placement);
         }}};
    for (const int bounces : {0, any_bounces}) {
        RenderSettings settings;
        settings.bounces.most = bounces;
        settings.occlusion = Occlusion::automatic;
        RelightSession session(scene, settings, {});
        value_or_exit(session.prepare());
        fmt::print("\n--bounces {}\n{:<16} {:<8} {:>10} {:>10} {:>12}\n", bounces == 0 ? "0" : "auto", "",
                   "frames", "vectors/ms", "frame/ms", "to a commit");
        for (const Kind& kind : kinds)
            for (const FrameQuality quality : {FrameQuality::still, FrameQuality::moving})
                print_frames(session, kind, quality);
    }
}

}  // namespace haarfield::baseline
