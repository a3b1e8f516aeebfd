#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstring>
#include <functional>
#include <mutex>
#include <thread>

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

/// A session without a page, which records incoming frames.
class Watched {
public:
    Watched(const Scene& scene, SceneEntities entities, ViewSettings settings, LightShelf& shelf)
        : session_(scene, std::move(entities), std::move(settings), shelf,
                   {[](PageId, const std::string&) {}, [this](const std::string& text) { note(text); },
                    [this](const SharedBytes& frame) { note(frame); },
                    [this](PageId, const SharedBytes& frame) { note(frame); }, [](PageId) {}}) {
        session_.join(1);
    }

    /// Sends a message and returns its number.
    std::uint32_t send(nlohmann::json message) {
        message["number"] = ++number_;
        session_.receive(1, message.dump());
        return number_;
    }

    /// Waits for a frame that shows a message, with at least the given exactness.
    void wait(std::uint32_t message, std::uint32_t exactness = 0) {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return has_frame_ && shown_ >= message && exactness_ >= exactness; });
    }

    /// Waits until all computation has finished.
    void wait_idle() {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return doing_.empty(); });
    }

    /// Waits until the session has reported a message as received: the preceding job has then been cancelled.
    void wait_taken(std::uint32_t message) {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return taken_ >= message; });
    }

    /// Tests whether a frame has shown a message with at least the given exactness.
    bool has_shown(std::uint32_t message, std::uint32_t exactness) {
        const std::lock_guard lock(mutex_);
        return has_frame_ && shown_ >= message && exactness_ >= exactness;
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
        const std::lock_guard lock(mutex_);
        if (message["type"] == "work") doing_ = message["doing"];
        if (message["type"] == "state") taken_ = message["message"];
        changed_.notify_all();
    }

    std::mutex mutex_;
    std::condition_variable changed_;
    bool has_frame_ = false;
    std::uint32_t number_ = 0, shown_ = 0, exactness_ = 0, taken_ = 0;
    std::string doing_;
    ViewSession session_;
};

/// Numbers of repetitions.
struct Repeats {
    int gestures, moments;
};
constexpr Repeats measured{60, 16}, tried{3, 2};
constexpr std::size_t least_measured = 1000;  // vertices; with fewer, the study is only a smoke test

/// Measures gestures of one kind, each sent as soon as the frame of the preceding one has arrived.
template <class MessageOf>
void print_gestures(Watched& watched, const char* what, const MessageOf& message_of, int gestures) {
    Clock::time_point start = Clock::now();
    watched.wait(watched.send(message_of(1)));
    const double first = milliseconds_since(start);
    // Vectors are computed while the last picture is displayed. Later frames use them.
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

/// The i-th gesture of a user.
using Gesture = std::function<nlohmann::json(int i)>;

/// A job that one gesture starts and another one cancels.
struct CancelledJob {
    const char* what;
    Gesture start, end;
    std::uint32_t exactness;  ///< Exactness of the frame that completes the job.
    bool waits_for_rest;      ///< The job starts only after the frames of the gesture itself.
};

/// Slightly longer than the pause after which a gesture has ended.
constexpr auto rest = std::chrono::milliseconds(155);

/// Measures how long a job takes to finish, and how long a cancelled job continues to run, for cancellation
/// at evenly spaced times.
void print_cancelled(Watched& watched, const CancelledJob& job, int moments) {
    static int i = 0;  // a new gesture every time
    const auto start = [&] {
        const std::uint32_t number = watched.send(job.start(++i));
        if (job.waits_for_rest) {
            watched.wait(number);
            std::this_thread::sleep_for(rest);
        } else {
            watched.wait_taken(number);
        }
        return number;
    };
    watched.wait_taken(watched.send(job.end(++i)));
    const std::uint32_t alone = start();
    Clock::time_point here = Clock::now();
    watched.wait(alone, job.exactness);
    const double whole = milliseconds_since(here);
    std::vector<double> taken;
    for (int moment = 0; moment < moments; ++moment) {
        watched.wait_taken(watched.send(job.end(++i)));
        const std::uint32_t number = start();
        std::this_thread::sleep_for(
            std::chrono::duration<double, std::milli>(whole * (moment + 0.5) / moments));
        if (watched.has_shown(number, job.exactness)) continue;
        here = Clock::now();
        watched.wait_taken(watched.send(job.end(++i)));
        taken.push_back(milliseconds_since(here));
    }
    std::ranges::sort(taken);
    if (taken.empty()) taken = {0};
    fmt::print("{:<30} {:>8.0f} {:>8} {:>8.1f} {:>8.1f}\n", job.what, whole, taken.size(),
               taken[taken.size() / 2], taken.back());
    std::fflush(stdout);
}

void print_session(const Scene& scene, int bounces, const Repeats& repeats) {
    SceneEntityOptions options;
    options.fields_folder = study_fields_folder();
    const Clock::time_point start = Clock::now();
    SceneEntities entities = value_or_exit(prepare_scene_entities(scene, options));
    LightShelf shelf(scene.environment, "", study_fields_folder());
    ViewSettings settings;
    settings.render.bounces.most = bounces;
    settings.tasks.output = study_fields_folder();
    std::size_t chair = 0;
    for (std::size_t i = 0; i < scene.instances.size(); ++i)
        if (scene.entities[scene.instances[i].entity].name == "chair") chair = i;
    const Vec3f place = scene.instances[chair].placement.translate;
    Watched watched(scene, std::move(entities), settings, shelf);
    watched.wait(0);
    std::fflush(stdout);
    fmt::print("\n--bounces {}: fields read and a shaded picture after {:.2f} s, exact after ",
               bounces == 0 ? "0" : "auto", 1e-3 * milliseconds_since(start));
    watched.wait(0, 2);
    fmt::print("{:.2f} s\n\n{:<22} {:>8} {:>8} {:>8} {:>8} {:>8}\n", 1e-3 * milliseconds_since(start),
               "gesture to frame [ms]", "first", "least", "median", "most", "exact");
    watched.wait_idle();
    const Gesture turn_light = [](int i) {
        return nlohmann::json{{"type", "turn_light"},
                              {"gesture", 1},
                              {"rotation", {0, std::sin(0.01 * i), 0, std::cos(0.01 * i)}}};
    };
    const Gesture move_eye = [](int i) {
        return nlohmann::json{
            {"type", "look"},        {"position", {2.5 * std::cos(0.02 * i), 1.5, 2.5 * std::sin(0.02 * i)}},
            {"target", {0, 0.4, 0}}, {"vertical_fov", 40},
            {"width", 640},          {"height", 480}};
    };
    const Gesture move_chair = [&](int i) {
        return nlohmann::json{{"type", "place"},
                              {"object", chair + 1},
                              {"gesture", 2},
                              {"translate", {double(place.x) + 0.001 * i, double(place.y), double(place.z)}}};
    };
    const Gesture turn_chair = [&](int i) {
        return nlohmann::json{{"type", "place"},
                              {"object", chair + 1},
                              {"gesture", 3},
                              {"rotation", {0, std::sin(0.01 * i), 0, std::cos(0.01 * i)}}};
    };
    print_gestures(watched, "light turns", turn_light, repeats.gestures);
    print_gestures(watched, "eye moves", move_eye, repeats.gestures);
    print_gestures(watched, "chair is moved", move_chair, repeats.gestures);

    fmt::print("\n{:<30} {:>8} {:>8} {:>8} {:>8}\n", "gesture to end of a job [ms]", "whole job", "gestures",
               "median", "most");
    for (const CancelledJob& job : {CancelledJob{"vectors for the light", turn_light, move_chair, 0, false},
                                    {"vectors for the eye", move_eye, move_chair, 0, false},
                                    {"vectors for a chair", move_chair, turn_light, 0, false},
                                    {"exact at rest", move_chair, move_chair, 2, true},
                                    {"a turned chair", turn_chair, turn_light, 1, false}})
        print_cancelled(watched, job, repeats.moments);
}

}  // namespace

void study_view(const std::string& file, std::size_t vertices) {
    const Scene scene = with_vertices(value_or_exit(read_scene(file)), vertices);
    fmt::print("{}: sessions without a page, all threads\n", scene.name);
    SceneEntityOptions options;
    options.fields_folder = study_fields_folder();
    value_or_exit(prepare_scene_entities(scene, options));  // computes the fields
    const Repeats repeats = vertices < least_measured ? tried : measured;
    print_session(scene, 0, repeats);
    print_session(scene, 1000, repeats);
}

}  // namespace haarfield::baseline
