#include "tools/view/session_pages.h"

#include <algorithm>

#include <nlohmann/json.hpp>

namespace haarfield {
namespace {

constexpr int protocol = 1;
constexpr auto work_period = std::chrono::milliseconds(100);

nlohmann::json sky_json(const AnalyticSky& sky) {
    constexpr double degrees = 180 / pi;
    return {{"turbidity", sky.turbidity},
            {"sun_elevation", double(sky.sun_elevation) * degrees},
            {"sun_azimuth", double(sky.sun_azimuth) * degrees}};
}

nlohmann::json camera_json(const Camera& camera) {
    return {{"position", json_of(camera.position)},
            {"target", json_of(camera.target)},
            {"vertical_fov", double(camera.vertical_fov) * (180 / pi)},
            {"width", camera.width},
            {"height", camera.height}};
}

}  // namespace

SessionPages::SessionPages(const LiveScene& live, const LightShelf& shelf, SessionFacts facts,
                           Audience audience)
    : live_(live), shelf_(shelf), facts_(std::move(facts)), audience_(std::move(audience)) {}

void SessionPages::join(PageId page, const History& history, const std::filesystem::path& left,
                        const std::optional<BakeError>& error) {
    pages_.push_back(page);
    tell_scene(page, history);
    tell_left_scene(page, left);
    if (last_frame_) audience_.show(page, last_frame_);
    if (error) tell_error(page, *error);
    sent_still_ = {};
    if (pages_.size() == 1) last_head_ = {};  // the new page starts counting
}

bool SessionPages::leave(PageId page) {
    const bool steered = steers(page);
    std::erase(pages_, page);
    return steered && steer(steering());
}

bool SessionPages::steer(PageId page) {
    const auto known = std::ranges::find(pages_, page);
    if (known == pages_.end()) return false;
    std::rotate(pages_.begin(), known, known + 1);
    for (const PageId each : pages_)
        tell(each, message_text({{"type", "steering"}, {"steers", each == page}}));
    return true;
}

void SessionPages::set_last_message(const MessageHead& head, Clock::time_point arrival) {
    last_head_ = head;
    message_time_ = arrival;
}

nlohmann::json SessionPages::state(const History& history, bool all) const {
    const Design& now = history.now();
    nlohmann::json message{{"type", "state"},
                           {"message", last_head_.number},
                           {"can_undo", history.can_undo()},
                           {"can_redo", history.can_redo()}};
    const bool knows = told_ && !all;
    const auto& instances = now.scene.instances;
    if (!knows || told_->ids != now.ids ||
        !std::ranges::equal(told_->scene.instances, instances, {}, &Instance::placement,
                            &Instance::placement)) {
        nlohmann::json& objects = message["objects"] = nlohmann::json::array();
        for (std::size_t i = 0; i < now.ids.size(); ++i) {
            // The shape is part of the mesh.
            const Placement& placement = instances[i].placement;
            objects.push_back({{"id", now.ids[i]},
                               {"name", instances[i].name},
                               {"entity", now.entities[i]},
                               {"translate", json_of(placement.translate)},
                               {"rotation", json_of(placement.rotate)},
                               {"scale", placement.scale}});
        }
    }
    const EnvironmentDescription& light = now.scene.environment;
    if (!knows || told_->light_stamp != now.light_stamp ||
        told_->scene.environment.exposure != light.exposure || told_->scene.environment.turn != light.turn ||
        (light.blend && told_->scene.environment.blend &&
         light.blend->share != told_->scene.environment.blend->share)) {
        nlohmann::json& lit = message["light"];
        lit = {{"light", shelf_.name_of(light.image, light.sky)}, {"rotation", json_of(light.turn)}};
        lit["second"] = light.blend ? nlohmann::json(shelf_.name_of(light.blend->image, light.blend->sky))
                                    : nlohmann::json();
        lit["share"] = light.blend ? light.blend->share : 0.5f;
        lit["stops"] = live_.exposure(now);
        lit["sky"] = light.sky ? sky_json(*light.sky) : nlohmann::json();
        lit["exposure"] = light.exposure ? nlohmann::json(*light.exposure) : nlohmann::json("auto");
    }
    if (!knows || told_->lamp_stamp != now.lamp_stamp) {
        nlohmann::json& lamps = message["lamps"] = nlohmann::json::array();
        for (const SceneLamp& lamp : now.scene.lamps)
            lamps.push_back({{"name", lamp.name},
                             {"colour", json_of(Vec3f(lamp.colour.x, lamp.colour.y, lamp.colour.z))},
                             {"position", json_of(lamp.position)}});
    }
    if (!knows || told_->material_stamp != now.material_stamp) {
        nlohmann::json& materials = message["materials"] = nlohmann::json::object();
        for (const auto& [name, material] : now.scene.materials) {
            materials[name] = json_of(material);
            materials[name]["has_image"] = !material.image.empty();
        }
        nlohmann::json& parts = message["part_materials"] = nlohmann::json::array();
        for (std::size_t e = 0; e < live_.entities().entities.size(); ++e)
            parts.push_back(
                part_materials(*live_.entities().entities[e], now.scene.entities[live_.described_by(e)]));
    }
    if (!knows || told_->scene.camera.position != now.scene.camera.position ||
        told_->scene.camera.target != now.scene.camera.target ||
        told_->scene.camera.vertical_fov != now.scene.camera.vertical_fov) {
        message["camera"] = camera_json(now.scene.camera);
        if (!all && has_stepped_) message["steps"] = true;
    }
    if (all) {
        nlohmann::json& lights = message["lights"] = nlohmann::json::array();
        for (const ShelfLight& each : shelf_.lights()) lights.push_back(each.name);
    }
    return message;
}

void SessionPages::tell_scene(PageId page, const History& history) const {
    const Scene& scene = history.now().scene;
    nlohmann::json message = state(history, true);
    message["type"] = "scene";
    message["protocol"] = protocol;
    message["session"] = facts_.session;
    message["name"] = scene.name;
    message["file"] = facts_.file;
    message["steers"] = steers(page);
    message["bounces"] =
        facts_.bounces == any_bounces ? nlohmann::json("auto") : nlohmann::json(facts_.bounces);
    nlohmann::json& entities = message["entities"] = nlohmann::json::array();
    for (std::size_t e = 0; e < live_.entities().entities.size(); ++e)
        entities.push_back(json_of(*live_.entities().entities[e], e, scene.entities[live_.described_by(e)]));
    tell(page, message_text(message));
}

void SessionPages::tell_state(const History& history) {
    const nlohmann::json message = state(history, false);
    const bool is_new =
        !told_ || message.size() > 4 || sent_undo_ != history.can_undo() || sent_redo_ != history.can_redo();
    if (!is_new) return;
    if (told_) tell_all(message_text(message));
    told_ = history.now();
    has_stepped_ = false;
    sent_undo_ = history.can_undo();
    sent_redo_ = history.can_redo();
}

void SessionPages::tell_lights(const History& history) const {
    for (const PageId page : pages_) tell(page, message_text(state(history, true)));
}

void SessionPages::tell_left_scene(PageId page, const std::filesystem::path& file) const {
    nlohmann::json message{{"type", "autosave"}, {"file", nullptr}};
    if (!file.empty()) message["file"] = file.filename().string();
    tell(page, message_text(message));
}

void SessionPages::tell_error(PageId page, const BakeError& error) const {
    nlohmann::json message{{"type", "measured"}, {"frame", frame_}, {"error", nullptr}};
    if (error.points > 0) {
        message["error"] = error.total;
        message["low"] = error.low;
        message["high"] = error.high;
        message["between_vertices"] = error.between;
    }
    tell(page, message_text(message));
}

void SessionPages::show_colours(const Design& design, Exactness exactness) {
    FrameHead head;
    head.frame = ++frame_;
    head.message = last_head_.number;
    head.exactness = exactness;
    head.milliseconds = std::chrono::duration<float, std::milli>(Clock::now() - message_time_).count();
    last_frame_ = std::make_shared<const std::string>(frame_bytes(head, design, live_.colours()));
    audience_.show_all(last_frame_);
}

void SessionPages::tell_work(const char* doing, std::string_view stage, double share) {
    const bool is_end = *doing == 0;
    const auto now = Clock::now();
    if (!is_end && now - sent_work_.load() < work_period) return;
    sent_work_ = now;
    tell_all(message_text({{"type", "work"},
                           {"doing", doing},
                           {"stage", stage},
                           {"share", share},
                           {"vector_bytes", is_end ? live_.transfer_bytes() : 0},
                           {"lacks_reflections", live_.lacks_reflections()}}));
}

void SessionPages::answer(PageId page, const Error& error, const MessageHead& to) const {
    tell(page, message_text(error_answer(error, to)));
}

void SessionPages::tell_trouble(const Error& error) const {
    tell_all(message_text(error_answer(error, last_head_)));
}

void SessionPages::tell_rest() {
    if (sent_still_ == std::pair(last_head_.number, frame_)) return;
    sent_still_ = {last_head_.number, frame_};
    tell_all(message_text({{"type", "rest"}, {"message", last_head_.number}, {"frame", frame_}}));
}

}  // namespace haarfield
