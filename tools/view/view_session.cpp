#include "tools/view/view_session.h"

#include <algorithm>

#include "fields/base/exception_message.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace haarfield {
namespace {

/// Edits pause after this time without input.
constexpr auto rest = std::chrono::milliseconds(150);
/// Likely edits are prepared after this time without input.
constexpr auto idle = std::chrono::milliseconds(400);
constexpr std::size_t most_arrivals = 4096;  // waiting messages

}  // namespace

ViewSession::ViewSession(const Scene& scene, SceneEntities entities, ViewSettings settings, LightShelf& shelf,
                         Audience audience)
    : settings_(std::move(settings)),
      shelf_(shelf),
      audience_(std::move(audience)),
      live_(scene, std::move(entities), settings_.render, settings_.transfer),
      history_(opened_design(scene, live_.entities())),
      tasks_(settings_.tasks,
             [this](const nlohmann::json& message) {
                 post({.page = 0,
                       .what = Arrival::What::task,
                       .message = {},
                       .text = message_text(message),
                       .time = {}});
             }),
      file_(settings_.scene_file),
      saved_(history_.now().scene),
      autosaved_(saved_),
      window_(scene.camera),
      last_input_(Clock::now() - rest),
      last_eye_(scene.camera.position),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

ViewSession::~ViewSession() {
    thread_.request_stop();
    {
        const std::lock_guard lock(mutex_);
        stop_job_.request_stop();
    }
    thread_.join();
    autosave();
    tasks_.cancel();
}

void ViewSession::join(PageId page) {
    post({.page = page, .what = Arrival::What::joined, .message = {}, .text = {}, .time = Clock::now()});
}

void ViewSession::leave(PageId page) {
    post({.page = page, .what = Arrival::What::left, .message = {}, .text = {}, .time = Clock::now()});
}

void ViewSession::lights_changed() {
    post({.page = 0, .what = Arrival::What::lights, .message = {}, .text = {}, .time = Clock::now()});
}

void ViewSession::receive(PageId page, std::string_view text) {
    Result<Message> message = read_message(text);
    if (!message) {
        audience_.tell(page, message_text(error_answer(message.error(), read_message_head(text))));
        return;
    }
    if (std::holds_alternative<FrameDisplayed>(message->content)) return audience_.shown(page);
    bool is_flooded = false;
    {
        const std::lock_guard lock(mutex_);
        is_flooded = arrivals_.size() >= most_arrivals;
    }
    if (is_flooded) {
        const MessageHead head{message->type, message->number};
        audience_.tell(page, message_text(error_answer({"", "too many waiting messages"}, head)));
        return;
    }
    post({.page = page,
          .what = Arrival::What::message,
          .message = std::move(*message),
          .text = {},
          .time = Clock::now()});
}

void ViewSession::post(Arrival arrival) {
    const std::lock_guard lock(mutex_);
    if (ends(arrival, job_)) stop_job_.request_stop();
    if (arrival.message && arrival.page == steering_)
        if (const auto* look = std::get_if<SetView>(&arrival.message->content))
            last_eye_ = look->camera.position;
    arrivals_.push_back(std::move(arrival));
    woken_.notify_all();
}

bool ViewSession::ends(const Arrival& arrival, const ViewJob& job) const {
    if (!arrival.message || arrival.page != steering_) return false;
    return job_ends_for(job, arrival.message->content,
                        has_specular_ ? std::optional(last_eye_) : std::nullopt);
}

void ViewSession::take_specular() {
    has_specular_ = std::ranges::any_of(live_.entities().entities, [](const auto& entity) {
        return std::ranges::any_of(entity->materials,
                                   [](const Material& material) { return material.specular != Rgb(0.0f); });
    });
}

void ViewSession::run(const std::stop_token& stop) {
    take_specular();
    if (const std::optional<Result<Scene>> left = file_.left_scene(); left && *left) left_ = **left;
    const std::stop_callback wake(stop, [this] { woken_.notify_all(); });
    while (!stop.stop_requested()) {
        std::deque<Arrival> arrivals;
        {
            const std::lock_guard lock(mutex_);
            arrivals.swap(arrivals_);
        }
        take_arrivals(std::move(arrivals));
        if (Clock::now() - last_input_ >= rest) autosave();  // before work that may take long
        if (exactness_ == Exactness::exact && is_shown()) {
            make_picture();
            tell_rest();
        }
        const ViewJob job = next_job();
        if (job.what == ViewJob::For::nothing) {
            std::unique_lock lock(mutex_);
            job_ = job;
            const auto pause = Clock::now() - last_input_;
            const auto until = pause < rest   ? rest - pause
                               : pause < idle ? idle - pause
                                              : std::chrono::seconds(10);
            woken_.wait_for(lock, stop, until, [this] { return !arrivals_.empty(); });
            continue;
        }
        Progress progress;
        {
            const std::lock_guard lock(mutex_);
            job_ = job;
            stop_job_ = std::stop_source();
            progress.stop = stop_job_.get_token();
            // Messages that arrived meanwhile may already end this job.
            if (stop.stop_requested() ||
                std::ranges::any_of(arrivals_, [&](const Arrival& arrival) { return ends(arrival, job); }))
                stop_job_.request_stop();
        }
        if (!progress.stop.stop_requested()) {
            const Result<Done> done = guarded_work(job, progress);
            if (!done && done.error().code != ErrorCode::interrupted) tell_trouble(done.error());
            take_specular();
        }
        const std::lock_guard lock(mutex_);
        job_ = {};
    }
}

bool ViewSession::is_shown(bool with_exposure) const {
    if (!shown_) return false;
    const DesignDifference found = difference(*shown_, history_.now());
    return !found.scene() && !(found.eye && has_specular_) && !(found.exposure && with_exposure);
}

ViewJob ViewSession::next_job() const {
    using What = ViewJob::For;
    const Design& now = history_.now();
    const auto pause = Clock::now() - last_input_;
    if (failed_light_ == now.light_stamp) return {};
    if (!is_shown()) {
        if (is_shown(/*with_exposure=*/false) && live_.can_expose(now)) return {What::frame, {}};
        if (live_.follows(now, live_.varied())) return {What::frame, live_.varied()};
        const bool is_gone = hand_.of == Variation::Of::object && !place_of(now, hand_.object);
        if (shown_ && hand_.of != Variation::Of::nothing && !is_gone) return {What::vectors, hand_};
        return {exactness_ == Exactness::exact && live_.commits_fast(now) ? What::recommit : What::shade, {}};
    }
    if (exactness_ != Exactness::exact) return pause >= rest ? ViewJob{What::commit, {}} : ViewJob{};
    Variation next = likely_;
    if (next.of == Variation::Of::object && !place_of(now, next.object)) next = {Variation::Of::light, 0};
    if (next.of == Variation::Of::eye && !has_specular_) next = {Variation::Of::light, 0};
    if (pause < idle) return {};
    if (!live_.follows(now, next)) return {What::likely, next};
    return error_ ? ViewJob{} : ViewJob{What::measure, {}};
}

Result<Done> ViewSession::guarded_work(const ViewJob& job, const Progress& progress) {
    try {
        return work(job, progress);
    } catch (const std::exception& exception) {  // out of memory
        return Error{"", exception_message(exception)};
    }
}

Result<Done> ViewSession::work(const ViewJob& job, const Progress& stop) {
    const Design& now = history_.now();
    const auto with_report = [&](const char* doing) {
        Progress progress = stop;
        progress.report = [this, doing](std::string_view stage, std::uint64_t done, std::uint64_t total) {
            tell_work(doing, stage, total > 0 ? double(done) / double(total) : 0);
        };
        return progress;
    };
    const auto shown_as = [&](Exactness exactness) {
        error_.reset();
        shown_ = now;
        exactness_ = exactness;
        show_colours(exactness);
        tell_work("", "", 1);
        return Done{};
    };
    switch (job.what) {
        case ViewJob::For::nothing: return Done{};
        case ViewJob::For::frame: {
            if (job.variation.of == Variation::Of::nothing) {
                const std::optional<BakeError> error = error_;  // exposure does not change it
                live_.expose(now);
                shown_as(exactness_);
                error_ = error;
                return Done{};
            }
            HF_TRY_DONE(live_.show(now, window_, FrameQuality::moving, stop));
            return shown_as(Exactness::moving);
        }
        case ViewJob::For::vectors: {
            HF_TRY_DONE(live_.vary(now, job.variation, with_report("vectors")));
            HF_TRY_DONE(live_.show(now, window_, FrameQuality::moving, stop));
            return shown_as(Exactness::moving);
        }
        case ViewJob::For::shade: {
            HF_TRY_DONE(live_.shade(now, with_report("shading")));
            return shown_as(Exactness::quick);
        }
        case ViewJob::For::recommit:
        case ViewJob::For::commit: {
            HF_TRY_DONE(live_.commit(now, with_report("exact")));
            return shown_as(Exactness::exact);
        }
        case ViewJob::For::likely: {
            const Result<Done> done = live_.vary(now, job.variation, with_report("ahead"));
            if (done) tell_work("", "", 1);
            return done;
        }
        case ViewJob::For::measure: {
            HF_TRY(error_, live_.error(now, window_, preview_, with_report("measuring")));
            for (const PageId page : pages_) tell_error(page);
            tell_work("", "", 1);
            return Done{};
        }
    }
    return Done{};
}

}  // namespace haarfield
