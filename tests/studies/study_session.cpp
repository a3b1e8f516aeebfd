#include <fmt/format.h>

#include <bit>
#include <chrono>
#include <cmath>
#include <ctime>
#include <iostream>
#include <string>

#include "scenes/scene_environment.h"
#include "scenes/scene_reader.h"
#include "scenes/scene_shading.h"
#include "shading/transfer/relight_session.h"
#include "tests/baselines/scene_integrals.h"
#include "tests/studies/study.h"

namespace haarfield::baseline {
namespace {

using Clock = std::chrono::steady_clock;

/// Applies step `number` of a gesture. tests/python/frame_times.py does the same.
void step(RelightSession& session, const std::string& gesture, int number) {
    const std::size_t last = session.instances().size() - 1;
    if (gesture == "light") {
        session.turn_environment(rotation_about({0, 1, 0}, number * 7.0 * (pi / 180)));
    } else if (gesture == "eye") {
        session.set_eye(Vec3f(Vec3d(2 + 0.125 * (number % 16), 1.5, 2)));
    } else {
        Placement placement = session.instances()[last].placement;
        placement.translate = Vec3f(Vec3d(-1 - 0.03125 * (number % 16), 0, 0.25));
        session.place(last, placement);
    }
}

Result<Done> vary(RelightSession& session, const std::string& gesture) {
    if (gesture == "light") return session.vary_light();
    if (gesture == "eye") return session.vary_eye();
    return session.vary_instance(session.instances().size() - 1);
}

/// Returns a checksum: the sum of the values' bits, each multiplied by a different odd number.
std::uint64_t digest(const SceneColours& radiance) {
    std::uint64_t sum = 0, weight = 1;
    for (const std::vector<Rgb>& instance : radiance)
        for (const Rgb& value : instance)
            for (const float channel : {value.x, value.y, value.z}) {
                sum += weight * std::bit_cast<std::uint32_t>(channel);
                weight += 2;
            }
    return sum;
}

}  // namespace

void study_session(const std::string& file, std::size_t frames) {
    const Scene description = value_or_exit(read_scene(file));
    SceneEntityOptions options;
    options.fields_folder = study_fields_folder();
    const SceneEntities entities = value_or_exit(prepare_scene_entities(description, options));
    RenderSettings settings;
    settings.occlusion = Occlusion::automatic;
    settings.bounces.most = any_bounces;
    RelightSession session(
        shaded_scene(description, entities, value_or_exit(scene_environment(description)).environment),
        settings);
    std::string gesture, varying;
    int number = 0;
    while (std::cin >> gesture) {
        if (gesture != varying) value_or_exit(vary(session, gesture));
        varying = gesture;
        double seconds = INFINITY, work = INFINITY;
        for (std::size_t i = 0; i < frames; ++i) {
            step(session, gesture, ++number);
            const std::clock_t work_start = std::clock();
            const Clock::time_point start = Clock::now();
            value_or_exit(session.frame());
            seconds = std::min(seconds, std::chrono::duration<double>(Clock::now() - start).count());
            work = std::min(work, double(std::clock() - work_start) / CLOCKS_PER_SEC);
        }
        fmt::print("{:.9f} {:.9f} {:016x}\n", seconds, work, digest(session.radiance()));
        std::fflush(stdout);
    }
}

}  // namespace haarfield::baseline
