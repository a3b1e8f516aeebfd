// The part of a session that sends messages to its pages and stores data for them.

#include "fields/base/names.h"
#include "fields/file/write_file.h"
#include "scenes/scene_writer.h"
#include "tools/view/view_session.h"

#include <fmt/format.h>
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

nlohmann::json ViewSession::state(bool all) const {
    const Design& now = history_.now();
    nlohmann::json message{{"type", "state"},
                           {"message", last_message_},
                           {"can_undo", history_.can_undo()},
                           {"can_redo", history_.can_redo()}};
    const bool knows = told_ && !all;
    const auto& instances = now.scene.instances;
    const auto same_places = [&] {
        if (told_->ids != now.ids) return false;
        for (std::size_t i = 0; i < now.ids.size(); ++i)
            if (told_->scene.instances[i].placement != instances[i].placement) return false;
        return true;
    };
    if (!knows || !same_places()) {
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

void ViewSession::tell_scene(PageId page) const {
    nlohmann::json message = state(true);
    message["type"] = "scene";
    message["protocol"] = protocol;
    message["session"] = settings_.session;
    message["name"] = history_.now().scene.name;
    message["file"] = file_.opened().filename().string();
    message["steers"] = pages_.front() == page;
    const int bounces = settings_.render.bounces.most;
    message["bounces"] = bounces == any_bounces ? nlohmann::json("auto") : nlohmann::json(bounces);
    nlohmann::json& entities = message["entities"] = nlohmann::json::array();
    const Scene& scene = history_.now().scene;
    for (std::size_t e = 0; e < live_.entities().entities.size(); ++e)
        entities.push_back(json_of(*live_.entities().entities[e], e, scene.entities[live_.described_by(e)]));
    audience_.tell(page, message_text(message));
}

void ViewSession::tell_state() {
    const nlohmann::json message = state(false);
    const bool is_new = !told_ || message.size() > 4 || sent_undo_ != history_.can_undo() ||
                        sent_redo_ != history_.can_redo();
    if (!is_new) return;
    if (told_) audience_.tell_all(message_text(message));
    told_ = history_.now();
    has_stepped_ = false;
    sent_undo_ = history_.can_undo();
    sent_redo_ = history_.can_redo();
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
        if (!is_end && now - sent_work_ < work_period) return;
        sent_work_ = now;
    }
    audience_.tell_all(message_text({{"type", "work"},
                                     {"doing", doing},
                                     {"stage", stage},
                                     {"share", share},
                                     {"vector_bytes", is_end ? live_.transfer_bytes() : 0},
                                     {"lacks_reflections", live_.lacks_reflections()}}));
}

void ViewSession::tell_trouble(const Error& error) {
    failed_light_ = history_.now().light_stamp;
    audience_.tell_all(message_text(error_answer(error, last_head_)));
}

void ViewSession::tell_rest() {
    if (sent_still_ == std::pair(last_message_, frame_)) return;
    sent_still_ = {last_message_, frame_};
    audience_.tell_all(message_text({{"type", "rest"}, {"message", last_message_}, {"frame", frame_}}));
}

void ViewSession::tell_error(PageId page) const {
    nlohmann::json message{{"type", "measured"}, {"frame", frame_}, {"error", nullptr}};
    if (error_->points > 0) {
        message["error"] = error_->total;
        message["low"] = error_->low;
        message["high"] = error_->high;
        message["between_vertices"] = error_->between;
    }
    audience_.tell(page, message_text(message));
}

Result<Done> ViewSession::save(PageId page, const Save& save, const Message& message) {
    HF_TRY(const SavedScene saved, file_.save(history_.now().scene, save.name.value_or("")));
    saved_ = history_.now().scene;
    if (!left_ && !settings_.scene_file.empty()) HF_TRY_DONE(file_.autosave(nullptr));
    autosaved_ = saved_;
    nlohmann::json answer{{"type", "saved"}, {"number", message.number}, {"file", saved.file.string()}};
    if (!saved.instead_of.empty()) answer["instead_of"] = saved.instead_of.string();
    audience_.tell(page, message_text(answer));
    return Done{};
}

/// Writes unsaved changes next to the scene, and removes that file when there are none.
void ViewSession::autosave() {
    const Scene& now = history_.now().scene;
    // The autosave of an earlier session remains until a page decides.
    if (left_ || settings_.scene_file.empty() || !is_changed(now, autosaved_)) return;
    autosaved_ = now;
    const Result<Done> done = file_.autosave(is_changed(now, saved_) ? &now : nullptr);
    if (!done && !autosave_has_failed_) audience_.tell_all(message_text(error_answer(done.error(), {})));
    autosave_has_failed_ = !done;
}

void ViewSession::tell_left_scene(PageId page) const {
    nlohmann::json message{{"type", "autosave"}, {"file", nullptr}};
    if (left_) message["file"] = file_.autosave_file().filename().string();
    audience_.tell(page, message_text(message));
}

Result<Done> ViewSession::start_task(PageId page, const StartTask& task, const Message&) {
    if (task.kind == TaskKind::picture) {
        pictures_.emplace_back(page, true);
        return Done{};
    }
    const std::string command = task.kind == TaskKind::bake ? "bake" : "reference";
    const Scene& scene = history_.now().scene;
    return tasks_.start(command, scene.name, scene_text(scene, tasks_.folder_of(command)));
}

void ViewSession::make_picture() {
    if (pictures_.empty()) return;
    const Image image = live_.picture(history_.now(), preview_);
    nlohmann::json message{{"type", "task"}, {"task", "picture"}, {"state", "done"}};
    const std::filesystem::path folder = tasks_.folder_of("picture");
    Result<Done> written = make_folder(folder);
    for (const char* ending : {"png", "exr"}) {
        const std::filesystem::path file =
            folder / fmt::format("{}_view.{}", plain_name(history_.now().scene.name), ending);
        if (written) written = write_image(image, file);
        if (written) message["files"].push_back(tasks_.add_file(file));
    }
    if (!written) {
        message["state"] = "failed";
        message["message"] = written.error().message();
    }
    for (const auto& [page, wanted] : pictures_) audience_.tell(page, message_text(message));
    pictures_.clear();
}

}  // namespace haarfield
