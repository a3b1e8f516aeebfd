#include "tools/view/view_session.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace haarfield {
namespace {

/// Hands rest after so long a pause.
constexpr auto rest = std::chrono::milliseconds(150);
/// What is likely to come is prepared after so long.
constexpr auto idle = std::chrono::milliseconds(400);
constexpr auto work_period = std::chrono::milliseconds(100);

bool same_scene(const Design& a, const Design& b) {
    if (a.ids != b.ids || a.light_stamp != b.light_stamp || a.material_stamp != b.material_stamp)
        return false;
    for (std::size_t i = 0; i < a.ids.size(); ++i)
        if (a.scene.instances[i].placement != b.scene.instances[i].placement) return false;
    const EnvironmentDescription &one = a.scene.environment, &other = b.scene.environment;
    return one.turn == other.turn &&
           (one.blend ? one.blend->share : 0) == (other.blend ? other.blend->share : 0);
}

/// Whether a place is that of a camera's eye or target: pages compute it with other roundings.
bool is_same_place(const Vec3f& one, const Vec3f& other, const Camera& camera) {
    constexpr float rounding = 1e-5f;
    return (one - other).length() <= rounding * (camera.target - camera.position).length();
}

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
      window_(scene.camera),
      last_input_(Clock::now() - rest),
      last_eye_(scene.camera.position),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

ViewSession::~ViewSession() {
    tasks_.cancel();
    thread_.request_stop();
    {
        const std::lock_guard lock(mutex_);
        stop_job_.request_stop();
    }
    thread_.join();
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
        audience_.tell(page, message_text({{"type", "error"}, {"message", message.error().what}}));
        return;
    }
    if (std::holds_alternative<Shown>(message->content)) return audience_.shown(page);
    post({.page = page,
          .what = Arrival::What::message,
          .message = std::move(*message),
          .text = {},
          .time = Clock::now()});
}

void ViewSession::post(Arrival arrival) {
    const std::lock_guard lock(mutex_);
    if (ends(arrival, job_)) stop_job_.request_stop();
    if (arrival.message)
        if (const auto* look = std::get_if<Look>(&arrival.message->content))
            last_eye_ = look->camera.position;
    arrivals_.push_back(std::move(arrival));
    woken_.notify_all();
}

bool ViewSession::ends(const Arrival& arrival, const Job& job) const {
    using What = Job::For;
    using Of = Variation::Of;
    if (!arrival.message || job.what == What::nothing || job.what == What::frame) return false;
    const auto ends_for = [&](const Variation& variation) {
        const bool is_vectors = job.what == What::vectors || job.what == What::likely;
        return !is_vectors || job.variation != variation;
    };
    const Content& content = arrival.message->content;
    if (std::holds_alternative<TurnLight>(content) || std::holds_alternative<NamedLights>(content) ||
        std::holds_alternative<MixLights>(content))
        return ends_for({Of::light, 0});
    if (const auto* look = std::get_if<Look>(&content))
        return has_highlights_ && !is_same_place(look->camera.position, last_eye_, look->camera) &&
               ends_for({Of::eye, 0});
    if (const auto* place = std::get_if<PartialPlace>(&content)) {
        if (!place->rotate) return ends_for({Of::object, place->object});
        return job.what != What::shade;  // what turns is shaded as often as that can be done
    }
    if (std::holds_alternative<SetExposure>(content))
        return job.what == What::commit || job.what == What::likely;
    if (std::holds_alternative<SetMaterial>(content))
        return job.what != What::shade && job.what != What::recommit;
    return std::holds_alternative<CloneObject>(content) || std::holds_alternative<DeleteObject>(content) ||
           std::holds_alternative<StepBack>(content) || std::holds_alternative<StepOn>(content);
}

void ViewSession::take_highlights() {
    has_highlights_ = std::ranges::any_of(live_.entities().entities, [](const auto& entity) {
        return std::ranges::any_of(entity->materials,
                                   [](const Material& material) { return material.specular != Rgb(0.0f); });
    });
}

void ViewSession::run(const std::stop_token& stop) {
    take_highlights();
    const std::stop_callback wake(stop, [this] { woken_.notify_all(); });
    while (!stop.stop_requested()) {
        std::deque<Arrival> arrivals;
        {
            const std::lock_guard lock(mutex_);
            arrivals.swap(arrivals_);
        }
        take_arrivals(std::move(arrivals));
        const Job job = next_job();
        if (job.what == Job::For::nothing) {
            if (exactness_ == Exactness::exact && is_shown()) {
                make_picture();
                tell_rest();
            }
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
            // What arrived meanwhile may be what this job would have to give way to.
            if (stop.stop_requested() ||
                std::ranges::any_of(arrivals_, [&](const Arrival& arrival) { return ends(arrival, job); }))
                stop_job_.request_stop();
        }
        if (!progress.stop.stop_requested()) {
            const Result<Done> done = work(job, progress);
            if (!done && done.error().what != interrupted) tell_trouble(done.error());
            take_highlights();
        }
        const std::lock_guard lock(mutex_);
        job_ = {};
    }
}

bool ViewSession::same_eye(const Design& a, const Design& b) const {
    return !has_highlights_ || a.scene.camera.position == b.scene.camera.position;
}

bool ViewSession::is_shown() const {
    return shown_ && same_scene(*shown_, history_.now()) && same_eye(*shown_, history_.now()) &&
           shown_->scene.environment.exposure == history_.now().scene.environment.exposure;
}

ViewSession::Job ViewSession::next_job() const {
    using What = Job::For;
    const Design& now = history_.now();
    const auto pause = Clock::now() - last_input_;
    if (failed_light_ == now.light_stamp) return {};
    if (!is_shown()) {
        if (shown_ && same_scene(*shown_, now) && same_eye(*shown_, now)) return {What::frame, {}};
        if (live_.follows(now, live_.varied())) return {What::frame, live_.varied()};
        const bool is_gone = hand_.of == Variation::Of::object && !place_of(now, hand_.object);
        if (shown_ && hand_.of != Variation::Of::nothing && !is_gone) return {What::vectors, hand_};
        return {exactness_ == Exactness::exact && live_.commits_fast(now) ? What::recommit : What::shade, {}};
    }
    if (exactness_ != Exactness::exact) return pause >= rest ? Job{What::commit, {}} : Job{};
    Variation next = likely_;
    if (next.of == Variation::Of::object && !place_of(now, next.object)) next = {Variation::Of::light, 0};
    if (next.of == Variation::Of::eye && !has_highlights_) next = {Variation::Of::light, 0};
    if (pause >= idle && !live_.follows(now, next)) return {What::likely, next};
    return {};
}

Result<Done> ViewSession::work(const Job& job, const Progress& stop) {
    const Design& now = history_.now();
    const auto with_report = [&](const char* doing) {
        Progress progress = stop;
        progress.report = [this, doing](std::string_view stage, std::uint64_t done, std::uint64_t total) {
            tell_work(doing, stage, total > 0 ? double(done) / double(total) : 0);
        };
        return progress;
    };
    const auto shown_as = [&](Exactness exactness) {
        shown_ = now;
        exactness_ = exactness;
        show_colours(exactness);
        tell_work("", "", 1);
        return Done{};
    };
    switch (job.what) {
        case Job::For::nothing: return Done{};
        case Job::For::frame: {
            if (job.variation.of == Variation::Of::nothing) {
                live_.expose(now);
                return shown_as(exactness_);
            }
            if (Result<Done> done = live_.show(now, window_, FrameQuality::moving, stop); !done) return done;
            return shown_as(Exactness::moving);
        }
        case Job::For::vectors: {
            if (Result<Done> done = live_.vary(now, job.variation, with_report("vectors")); !done)
                return done;
            if (Result<Done> done = live_.show(now, window_, FrameQuality::moving, stop); !done) return done;
            return shown_as(Exactness::moving);
        }
        case Job::For::shade: {
            if (Result<Done> done = live_.shade(now, with_report("shading")); !done) return done;
            return shown_as(Exactness::quick);
        }
        case Job::For::recommit:
        case Job::For::commit: {
            if (Result<Done> done = live_.commit(now, with_report("exact")); !done) return done;
            return shown_as(Exactness::exact);
        }
        case Job::For::likely: {
            const Result<Done> done = live_.vary(now, job.variation, with_report("ahead"));
            if (done) tell_work("", "", 1);
            return done;
        }
    }
    return Done{};
}

void ViewSession::show_colours(Exactness exactness) {
    FrameHead head;
    head.frame = ++frame_;
    head.message = last_message_;
    head.exactness = exactness;
    head.milliseconds = std::chrono::duration<float, std::milli>(Clock::now() - message_time_).count();
    last_frame_ = std::make_shared<const std::string>(frame_bytes(head, history_.now(), live_.colours()));
    audience_.show_all(last_frame_);
}

void ViewSession::tell_work(const char* doing, std::string_view stage, double share) {
    const bool is_end = *doing == 0;
    {
        const std::lock_guard lock(mutex_);
        const auto now = Clock::now();
        if (!is_end && now - told_work_ < work_period) return;
        told_work_ = now;
    }
    audience_.tell_all(message_text({{"type", "work"},
                                     {"doing", doing},
                                     {"stage", stage},
                                     {"share", share},
                                     {"vector_bytes", is_end ? live_.transfer_bytes() : 0}}));
}

void ViewSession::take_arrivals(std::deque<Arrival> arrivals) {
    for (const Arrival& arrival : arrivals) {
        switch (arrival.what) {
            case Arrival::What::message: take_message(arrival); break;
            case Arrival::What::joined:
                pages_.push_back(arrival.page);
                tell_scene(arrival.page);
                if (last_frame_) audience_.show(arrival.page, last_frame_);
                told_rest_ = {};
                if (pages_.size() > 1) break;
                last_message_ = 0;  // it counts anew
                history_.end_gesture();
                break;
            case Arrival::What::left: {
                const bool steered = !pages_.empty() && pages_.front() == arrival.page;
                std::erase(pages_, arrival.page);
                if (steered && !pages_.empty()) steer(PageId(pages_.front()));
                break;
            }
            case Arrival::What::lights:
                for (const PageId page : pages_) {
                    nlohmann::json message = state(true);
                    audience_.tell(page, message_text(message));
                }
                break;
            case Arrival::What::task: audience_.tell_all(arrival.text); break;
        }
    }
    if (failed_light_ != history_.now().light_stamp)
        if (const Result<Done> taken = live_.take_light(history_.now()); !taken) tell_trouble(taken.error());
    tell_state();
}

void ViewSession::tell_trouble(const Error& error) {
    failed_light_ = history_.now().light_stamp;
    audience_.tell_all(message_text({{"type", "error"}, {"message", error.message()}}));
}

void ViewSession::tell_rest() {
    if (told_rest_ == std::pair(last_message_, frame_)) return;
    told_rest_ = {last_message_, frame_};
    audience_.tell_all(message_text({{"type", "rest"}, {"message", last_message_}, {"frame", frame_}}));
}

void ViewSession::take_message(const Arrival& arrival) {
    const Message& message = *arrival.message;
    Result<Done> done = Done{};
    const bool is_open = std::holds_alternative<Steer>(message.content);
    if (!is_open && (pages_.empty() || pages_.front() != arrival.page)) {
        done = Error{"", "another page steers; wanted `steer` first"};
    } else {
        done = take_content(arrival.page, message);
    }
    if (!done) {
        audience_.tell(arrival.page, message_text({{"type", "error"},
                                                   {"about", message.type},
                                                   {"number", message.number},
                                                   {"message", done.error().message()}}));
        return;
    }
    if (is_open) return;
    last_input_ = arrival.time;
    message_time_ = arrival.time;
    last_message_ = message.number;
}

Result<Done> ViewSession::make_edit(const Edit& edit, const Message& message, const Variation& hand) {
    if (Result<Done> done = history_.make(edit, message.gesture); !done) return done;
    hand_ = hand;
    if (hand.of != Variation::Of::nothing) likely_ = hand;
    return Done{};
}

Result<Done> ViewSession::take_content(PageId page, const Message& message) {
    using Of = Variation::Of;
    return std::visit(
        [&](const auto& content) -> Result<Done> {
            using Type = std::decay_t<decltype(content)>;
            if constexpr (std::is_same_v<Type, TurnLight> || std::is_same_v<Type, MixLights>) {
                return make_edit(content, message, {Of::light, 0});
            } else if constexpr (std::is_same_v<Type, SetExposure>) {
                return make_edit(content, message, hand_);
            } else if constexpr (std::is_same_v<Type, SetMaterial> || std::is_same_v<Type, CloneObject> ||
                                 std::is_same_v<Type, DeleteObject>) {
                return make_edit(content, message, {});
            } else if constexpr (std::is_same_v<Type, NamedLights>) {
                return take_lights(content, message);
            } else if constexpr (std::is_same_v<Type, PartialPlace>) {
                return take_place(content, message);
            } else if constexpr (std::is_same_v<Type, Look>) {
                return take_look(content, message);
            } else if constexpr (std::is_same_v<Type, Select>) {
                if (content.object && !place_of(history_.now(), *content.object))
                    return Error{"", fmt::format("there is no object {}", *content.object)};
                if (content.object) likely_ = {Of::object, *content.object};
            } else if constexpr (std::is_same_v<Type, StepBack> || std::is_same_v<Type, StepOn>) {
                const bool done = std::is_same_v<Type, StepBack> ? history_.undo() : history_.redo();
                if (!done) return Error{"", "there is nothing more to take back or to do again"};
                hand_ = {};
                look_as_designed();
            } else if constexpr (std::is_same_v<Type, Save>) {
                return save(page, content, message);
            } else if constexpr (std::is_same_v<Type, StartTask>) {
                return start_task(page, content, message);
            } else if constexpr (std::is_same_v<Type, CancelTask>) {
                tasks_.cancel();
            } else if constexpr (std::is_same_v<Type, Steer>) {
                steer(page);
            }
            return Done{};
        },
        message.content);
}

Result<Done> ViewSession::take_lights(const NamedLights& lights, const Message& message) {
    const std::optional<ShelfLight> first = shelf_.find(lights.first);
    if (!first) return Error{"", fmt::format("there is no light \"{}\"", lights.first)};
    ChooseLight edit;
    edit.light.image = first->image;
    edit.light.sky = first->sky;
    if (lights.second) {
        const std::optional<ShelfLight> second = shelf_.find(*lights.second);
        if (!second) return Error{"", fmt::format("there is no light \"{}\"", *lights.second)};
        edit.light.blend = BlendedLight{second->image, second->sky, lights.share};
    }
    if (Result<Done> known = live_.lights().know(edit.light); !known) return known;
    return make_edit(edit, message, {Variation::Of::light, 0});
}

Result<Done> ViewSession::take_place(const PartialPlace& place, const Message& message) {
    const std::optional<std::size_t> at = place_of(history_.now(), place.object);
    if (!at) return Error{"", fmt::format("there is no object {}", place.object)};
    Placement placement = history_.now().scene.instances[*at].placement;
    if (place.translate) placement.translate = *place.translate;
    if (place.scale) placement.scale = *place.scale;
    if (place.rotate) placement.rotate = *place.rotate;
    return make_edit(PlaceObject{place.object, placement}, message,
                     place.rotate ? Variation{} : Variation{Variation::Of::object, place.object});
}

Result<Done> ViewSession::take_look(const Look& look, const Message& message) {
    window_ = look.camera;
    has_stepped_ = false;
    const Camera& now = history_.now().scene.camera;
    const bool has_moved = !is_same_place(look.camera.position, now.position, look.camera);
    const bool has_turned = !is_same_place(look.camera.target, now.target, look.camera);
    if (!has_moved && !has_turned) return Done{};
    const MoveEye edit{has_moved ? look.camera.position : now.position,
                       has_turned ? look.camera.target : now.target};
    if (Result<Done> done = history_.make(edit, message.gesture); !done) return done;
    if (has_moved && has_highlights_) likely_ = hand_ = {Variation::Of::eye, 0};
    return Done{};
}

/// The page is to look from where a step has led.
void ViewSession::look_as_designed() {
    const Camera& camera = history_.now().scene.camera;
    if (window_.position == camera.position && window_.target == camera.target) return;
    window_.position = camera.position;
    window_.target = camera.target;
    has_stepped_ = true;
    const std::lock_guard lock(mutex_);
    last_eye_ = camera.position;
}

void ViewSession::steer(PageId page) {
    const auto known = std::ranges::find(pages_, page);
    if (known == pages_.end()) return;
    history_.end_gesture();
    std::rotate(pages_.begin(), known, known + 1);
    for (const PageId each : pages_)
        audience_.tell(each, message_text({{"type", "steering"}, {"steers", each == page}}));
}

}  // namespace haarfield
