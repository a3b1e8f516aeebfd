#include "tools/view/view_session.h"

#include <algorithm>

#include "fields/base/exception_message.h"
#include "fields/base/names.h"
#include "fields/file/write_file.h"
#include "scenes/scene_writer.h"

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
    : shelf_(shelf),
      live_(scene, std::move(entities), settings.render, settings.transfer),
      pages_(live_, shelf,
             {settings.session, settings.scene_file.filename().string(), settings.render.bounces.most},
             std::move(audience)),
      editor_(scene, settings.scene_file, live_, shelf, pages_),
      tasks_(std::move(settings.tasks),
             [this](const nlohmann::json& message) {
                 post({.what = Arrival::What::task, .text = message_text(message)});
             }),
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
    editor_.autosave();
    tasks_.cancel();
}

void ViewSession::join(PageId page) {
    post({.page = page, .what = Arrival::What::joined});
}

void ViewSession::leave(PageId page) {
    post({.page = page, .what = Arrival::What::left});
}

void ViewSession::lights_changed() {
    post({.what = Arrival::What::lights});
}

void ViewSession::receive(PageId page, std::string_view text) {
    Result<Message> message = read_message(text);
    if (!message) return pages_.answer(page, message.error(), read_message_head(text));
    if (std::holds_alternative<FrameDisplayed>(message->content)) return pages_.shown(page);
    bool is_flooded = false;
    {
        const std::lock_guard lock(mutex_);
        is_flooded = arrivals_.size() >= most_arrivals;
    }
    if (is_flooded)
        return pages_.answer(page, {"", "too many waiting messages"}, {message->type, message->number});
    post({.page = page, .message = std::move(*message)});
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

void ViewSession::take_arrivals(std::deque<Arrival> arrivals) {
    for (const Arrival& arrival : arrivals) {
        switch (arrival.what) {
            case Arrival::What::message: take_message(arrival); break;
            case Arrival::What::joined:
                pages_.join(arrival.page, editor_.history(), editor_.left_file(), error_);
                if (pages_.steers(arrival.page)) editor_.end_gesture();
                break;
            case Arrival::What::left:
                if (pages_.leave(arrival.page)) editor_.end_gesture();
                break;
            case Arrival::What::lights: pages_.tell_lights(editor_.history()); break;
            case Arrival::What::task: pages_.tell_all(arrival.text); break;
        }
    }
    {
        const std::lock_guard lock(mutex_);
        steering_ = pages_.steering();
    }
    const Design& now = editor_.now();
    if (failed_light_ != now.light_stamp)
        if (const Result<Done> taken = live_.take_light(now); !taken) tell_trouble(taken.error());
    if (const std::optional<AnalyticSky>& sky = now.scene.environment.sky) shelf_.set_sky(*sky);
    pages_.tell_state(editor_.history());
}

void ViewSession::take_message(const Arrival& arrival) {
    const Message& message = *arrival.message;
    const MessageHead head{message.type, message.number};
    const Result<Done> done = take_content(arrival.page, message);
    if (!done) return pages_.answer(arrival.page, done.error(), head);
    if (std::holds_alternative<Steer>(message.content)) return;
    last_input_ = arrival.time;
    pages_.set_last_message(head, arrival.time);
}

Result<Done> ViewSession::take_content(PageId page, const Message& message) {
    if (std::holds_alternative<Steer>(message.content)) {
        if (pages_.steer(page)) editor_.end_gesture();
        return Done{};
    }
    if (!pages_.steers(page)) return Error{"", "another page steers; send `steer` first"};
    if (const auto* task = std::get_if<StartTask>(&message.content)) return start_task(page, task->kind);
    if (std::holds_alternative<CancelTask>(message.content)) tasks_.cancel();
    HF_TRY(const WindowChange change, editor_.apply(page, message));
    if (change == WindowChange::none) return Done{};
    error_.reset();
    pages_.set_stepped(change == WindowChange::by_step);
    if (change == WindowChange::by_page) return Done{};
    const std::lock_guard lock(mutex_);
    last_eye_ = editor_.window().position;
    return Done{};
}

Result<Done> ViewSession::start_task(PageId page, TaskKind kind) {
    if (kind == TaskKind::picture) {
        pictures_.push_back(page);
        return Done{};
    }
    const std::string command = kind == TaskKind::bake ? "bake" : "reference";
    const Scene& scene = editor_.now().scene;
    return tasks_.start(command, scene.name, scene_text(scene, tasks_.folder_of(command)));
}

void ViewSession::make_picture() {
    if (pictures_.empty()) return;
    const Image image = live_.picture(editor_.now(), preview_);
    nlohmann::json message{{"type", "task"}, {"task", "picture"}, {"state", "done"}};
    const std::filesystem::path folder = tasks_.folder_of("picture");
    Result<Done> written = make_folder(folder);
    for (const char* ending : {"png", "exr"}) {
        const std::filesystem::path file =
            folder / fmt::format("{}_view.{}", plain_name(editor_.now().scene.name), ending);
        if (written) written = write_image(image, file);
        if (written) message["files"].push_back(tasks_.add_file(file));
    }
    if (!written) {
        message["state"] = "failed";
        message["message"] = written.error().message();
    }
    for (const PageId page : pictures_) pages_.tell(page, message_text(message));
    pictures_.clear();
}

void ViewSession::tell_trouble(const Error& error) {
    failed_light_ = editor_.now().light_stamp;
    pages_.tell_trouble(error);
}

void ViewSession::run(const std::stop_token& stop) {
    has_specular_ = live_.has_specular();
    editor_.read_left_scene();
    const std::stop_callback wake(stop, [this] { woken_.notify_all(); });
    while (!stop.stop_requested()) {
        std::deque<Arrival> arrivals;
        {
            const std::lock_guard lock(mutex_);
            arrivals.swap(arrivals_);
        }
        take_arrivals(std::move(arrivals));
        if (Clock::now() - last_input_ >= rest) editor_.autosave();  // before work that may take long
        if (exactness_ == Exactness::exact && is_shown()) {
            make_picture();
            pages_.tell_rest();
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
            has_specular_ = live_.has_specular();
        }
        const std::lock_guard lock(mutex_);
        job_ = {};
    }
}

bool ViewSession::is_shown(bool with_exposure) const {
    if (!shown_) return false;
    const DesignDifference found = difference(*shown_, editor_.now());
    return !found.scene() && !(found.eye && has_specular_) && !(found.exposure && with_exposure);
}

ViewJob ViewSession::next_job() const {
    using What = ViewJob::For;
    const Design& now = editor_.now();
    const Variation& hand = editor_.hand();
    const auto pause = Clock::now() - last_input_;
    if (failed_light_ == now.light_stamp) return {};
    if (!is_shown()) {
        if (is_shown(/*with_exposure=*/false) && live_.can_expose(now)) return {What::frame, {}};
        if (live_.follows(now, live_.varied())) return {What::frame, live_.varied()};
        const bool is_gone = hand.of == Variation::Of::object && !place_of(now, hand.object);
        if (shown_ && hand.of != Variation::Of::nothing && !is_gone) return {What::vectors, hand};
        return {exactness_ == Exactness::exact && live_.commits_fast(now) ? What::recommit : What::shade, {}};
    }
    if (exactness_ != Exactness::exact) return pause >= rest ? ViewJob{What::commit, {}} : ViewJob{};
    Variation next = editor_.likely();
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
    const Design& now = editor_.now();
    const Camera& window = editor_.window();
    const auto with_report = [&](const char* doing) {
        Progress progress = stop;
        progress.report = [this, doing](std::string_view stage, std::uint64_t done, std::uint64_t total) {
            pages_.tell_work(doing, stage, total > 0 ? double(done) / double(total) : 0);
        };
        return progress;
    };
    const auto shown_as = [&](Exactness exactness) {
        error_.reset();
        shown_ = now;
        exactness_ = exactness;
        pages_.show_colours(now, exactness);
        pages_.tell_work("", "", 1);
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
            HF_TRY_DONE(live_.show(now, window, FrameQuality::moving, stop));
            return shown_as(Exactness::moving);
        }
        case ViewJob::For::vectors: {
            HF_TRY_DONE(live_.vary(now, job.variation, with_report("vectors")));
            HF_TRY_DONE(live_.show(now, window, FrameQuality::moving, stop));
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
            if (done) pages_.tell_work("", "", 1);
            return done;
        }
        case ViewJob::For::measure: {
            HF_TRY(error_, live_.error(now, window, preview_, with_report("measuring")));
            for (const PageId page : pages_.all()) pages_.tell_error(page, *error_);
            pages_.tell_work("", "", 1);
            return Done{};
        }
    }
    return Done{};
}

}  // namespace haarfield
