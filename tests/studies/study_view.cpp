#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstring>
#include <mutex>

#include "scenes/scene_reader.h"
#include "tests/baselines/scene_integrals.h"
#include "tests/studies/study.h"
#include "tools/view/view_session.h"

namespace haarfield::baseline {
namespace {

using Clock = std::chrono::steady_clock;

double milliseconds_since(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// A session without a page: frames are noted as they come.
class Watched {
public:
    Watched(const Scene& scene, SceneEntities entities, ViewSettings settings, LightShelf& shelf)
        : session_(scene, std::move(entities), std::move(settings), shelf,
                   {[](PageId, const std::string&) {}, [this](const std::string& text) { note(text); },
                    [this](const SharedBytes& frame) { note(frame); },
                    [this](PageId, const SharedBytes& frame) { note(frame); }, [](PageId) {}}) {
        session_.join(1);
    }

    /// Sends a message; its number.
    std::uint32_t send(nlohmann::json message) {
        message["number"] = ++number_;
        session_.receive(1, message.dump());
        return number_;
    }

    /// Until a frame shows a message, at least as exactly.
    void wait(std::uint32_t message, std::uint32_t exactness = 0) {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return has_frame_ && shown_ >= message && exactness_ >= exactness; });
    }

    /// Until nothing is computed any more.
    void wait_idle() {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return doing_.empty(); });
    }

private:
    void note(const SharedBytes& frame) {
        const std::lock_guard lock(mutex_);
        std::memcpy(&shown_, frame->data() + 8, sizeof shown_);
        std::memcpy(&exactness_, frame->data() + 12, sizeof exactness_);
        has_frame_ = true;
        changed_.notify_all();
    }
    void note(const std::string& text) {
        const nlohmann::json message = nlohmann::json::parse(text);
        if (message["type"] != "work") return;
        const std::lock_guard lock(mutex_);
        doing_ = message["doing"];
        changed_.notify_all();
    }

    std::mutex mutex_;
    std::condition_variable changed_;
    bool has_frame_ = false;
    std::uint32_t number_ = 0, shown_ = 0, exactness_ = 0;
    std::string doing_;
    ViewSession session_;
};

/// Gestures of one kind, each as soon as the one before is seen.
template <class MessageOf>
void print_gestures(Watched& watched, const char* what, const MessageOf& message_of) {
    constexpr int gestures = 60;
    Clock::time_point start = Clock::now();
    watched.wait(watched.send(message_of(1)));
    const double first = milliseconds_since(start);
    // The vectors are made while the last picture stays; then frames come by them.
    start = Clock::now();
    double previous = first;
    int made = 2;
    for (; made < 200 && previous > 0.3 * first && first > 200; ++made) {
        const Clock::time_point here = Clock::now();
        watched.wait(watched.send(message_of(made)));
        previous = milliseconds_since(here);
    }
    std::vector<double> taken;
    for (int i = 0; i < gestures; ++i) {
        const Clock::time_point here = Clock::now();
        watched.wait(watched.send(message_of(made + i)));
        taken.push_back(milliseconds_since(here));
    }
    std::ranges::sort(taken);
    start = Clock::now();
    watched.wait(watched.send(message_of(made + gestures)), 2);
    fmt::print("{:<22} {:>8.0f} {:>8.1f} {:>8.1f} {:>8.1f} {:>8.0f}\n", what, first, taken.front(),
               taken[taken.size() / 2], taken.back(), milliseconds_since(start));
    watched.wait_idle();
}

void print_session(const Scene& scene, int bounces) {
    SceneEntityOptions options;
    options.fields_folder = study_fields_folder();
    SceneEntities entities = value_or_exit(prepare_scene_entities(scene, options));
    LightShelf shelf(scene.environment, "", study_fields_folder());
    ViewSettings settings;
    settings.render.bounces.most = bounces;
    settings.tasks.output = study_fields_folder();
    std::size_t chair = 0;
    for (std::size_t i = 0; i < scene.instances.size(); ++i)
        if (scene.entities[scene.instances[i].entity].name == "chair") chair = i;
    const Vec3f place = scene.instances[chair].placement.translate;
    const Clock::time_point start = Clock::now();
    Watched watched(scene, std::move(entities), settings, shelf);
    watched.wait(0);
    std::fflush(stdout);
    fmt::print("\n--bounces {}: a shaded picture after {:.2f} s, exact after ", bounces == 0 ? "0" : "auto",
               1e-3 * milliseconds_since(start));
    watched.wait(0, 2);
    fmt::print("{:.2f} s\n\n{:<22} {:>8} {:>8} {:>8} {:>8} {:>8}\n", 1e-3 * milliseconds_since(start),
               "gesture to frame [ms]", "first", "least", "median", "most", "exact");
    watched.wait_idle();
    print_gestures(watched, "light turns", [](int i) {
        return nlohmann::json{{"type", "turn_light"},
                              {"gesture", 1},
                              {"rotation", {0, std::sin(0.01 * i), 0, std::cos(0.01 * i)}}};
    });
    print_gestures(watched, "eye moves", [](int i) {
        return nlohmann::json{
            {"type", "look"},        {"position", {2.5 * std::cos(0.02 * i), 1.5, 2.5 * std::sin(0.02 * i)}},
            {"target", {0, 0.4, 0}}, {"vertical_fov", 40},
            {"width", 640},          {"height", 480}};
    });
    print_gestures(watched, "chair is moved", [&](int i) {
        return nlohmann::json{{"type", "place"},
                              {"object", chair + 1},
                              {"gesture", 2},
                              {"translate", {double(place.x) + 0.004 * i, double(place.y), double(place.z)}}};
    });
}

}  // namespace

void study_view(const std::string& file, std::size_t vertices) {
    const Scene scene = with_vertices(value_or_exit(read_scene(file)), vertices);
    fmt::print("{}: sessions without a page, all threads\n", scene.name);
    print_session(scene, 0);
    print_session(scene, 1000);
}

}  // namespace haarfield::baseline
