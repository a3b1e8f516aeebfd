// The part of a session that processes arriving messages: changes of the design, and answers.

#include "tools/view/view_session.h"

#include "scenes/povray_finish.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace haarfield {
namespace {

/// Returns a model's own material as a scene file can describe it: physical materials unchanged, materials of
/// the povray convention as a finish with a white specular colour.
SceneMaterial scene_material(const Surface& surface) {
    SceneMaterial material;
    static_cast<Material&>(material) = surface.material;
    material.emission = surface.emission;
    if (material.convention != LobeConvention::povray) return material;
    const auto largest = [](const Rgb& colour) { return std::max({colour.x, colour.y, colour.z}); };
    const float diffuse = largest(material.diffuse), highlights = largest(material.specular);
    material.pigment = diffuse > 0 ? material.diffuse / diffuse : Rgb(1.0f);
    material.emission = material.pigment * largest(material.emission);
    material.phong *= highlights;
    material.blinn *= highlights;
    material.specular = Rgb(material.phong > 0 || material.blinn > 0 ? 1.0f : 0.0f);
    material.shininess = std::min(material.shininess, float(shininesses.highest));
    return material;
}

/// A visitor of a variant, composed of one function for each alternative.
template <class... Functions>
struct Overloads : Functions... {
    using Functions::operator()...;
};

}  // namespace

void ViewSession::take_arrivals(std::deque<Arrival> arrivals) {
    for (const Arrival& arrival : arrivals) {
        switch (arrival.what) {
            case Arrival::What::message: take_message(arrival); break;
            case Arrival::What::joined:
                pages_.push_back(arrival.page);
                tell_scene(arrival.page);
                tell_left_scene(arrival.page);
                if (last_frame_) audience_.show(arrival.page, last_frame_);
                if (error_) tell_error(arrival.page);
                sent_still_ = {};
                if (pages_.size() > 1) break;
                last_message_ = 0;  // the new page starts counting
                last_head_ = {};
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
    {
        const std::lock_guard lock(mutex_);
        steering_ = pages_.empty() ? 0 : pages_.front();
    }
    if (failed_light_ != history_.now().light_stamp)
        if (const Result<Done> taken = live_.take_light(history_.now()); !taken) tell_trouble(taken.error());
    if (const std::optional<AnalyticSky>& sky = history_.now().scene.environment.sky) shelf_.set_sky(*sky);
    tell_state();
}

void ViewSession::take_message(const Arrival& arrival) {
    const Message& message = *arrival.message;
    Result<Done> done = Done{};
    const bool is_open = std::holds_alternative<Steer>(message.content);
    if (!is_open && (pages_.empty() || pages_.front() != arrival.page)) {
        done = Error{"", "another page steers; send `steer` first"};
    } else {
        done = take_content(arrival.page, message);
    }
    if (!done) {
        audience_.tell(arrival.page,
                       message_text(error_answer(done.error(), {message.type, message.number})));
        return;
    }
    if (is_open) return;
    last_input_ = arrival.time;
    message_time_ = arrival.time;
    last_message_ = message.number;
    last_head_ = {message.type, message.number};
}

Result<Done> ViewSession::make_edit(const Edit& edit, const Message& message, const Variation& hand) {
    HF_TRY_DONE(history_.make(edit, message.gesture));
    hand_ = hand;
    if (hand.of != Variation::Of::nothing) likely_ = hand;
    return Done{};
}

Result<Done> ViewSession::take_content(PageId page, const Message& message) {
    const Variation light{Variation::Of::light, 0}, nothing;
    const auto step = [&](bool has_stepped) -> Result<Done> {
        if (!has_stepped) return Error{"", "there is nothing more to take back or to do again"};
        hand_ = {};
        look_as_designed();
        return Done{};
    };
    return std::visit(
        Overloads{
            [&](const TurnLight& edit) { return make_edit(edit, message, light); },
            [&](const MixLights& edit) { return make_edit(edit, message, light); },
            [&](const SetSky& edit) { return make_edit(edit, message, light); },
            [&](const SetExposure& edit) { return make_edit(edit, message, hand_); },
            [&](const SetMaterial& edit) { return make_edit(edit, message, nothing); },
            [&](const SetLamp& edit) { return make_edit(edit, message, nothing); },
            [&](const CloneObject& edit) { return make_edit(edit, message, nothing); },
            [&](const DeleteObject& edit) { return make_edit(edit, message, nothing); },
            [&](const EditPartMaterial& part) { return own_part(part, message); },
            [&](const NamedLights& lights) { return take_lights(lights, message); },
            [&](const PartialPlace& place) { return take_place(place, message); },
            [&](const SetView& look) { return take_look(look, message); },
            [&](const Select& selected) -> Result<Done> {
                if (selected.object && !place_of(history_.now(), *selected.object))
                    return Error{"", fmt::format("there is no object {}", *selected.object)};
                if (selected.object) likely_ = {Variation::Of::object, *selected.object};
                return Done{};
            },
            [&](const StepBack&) { return step(history_.undo()); },
            [&](const StepOn&) { return step(history_.redo()); },
            [&](const Save& file) { return save(page, file, message); },
            [&](const StartTask& task) { return start_task(page, task, message); },
            [&](const Restore&) { return restore(message); },
            [&](const Discard&) {
                decide_left_scene();
                return file_.autosave(nullptr);
            },
            [&](const CancelTask&) -> Result<Done> {
                tasks_.cancel();
                return Done{};
            },
            [&](const Steer&) -> Result<Done> {
                steer(page);
                return Done{};
            },
            [](const FrameDisplayed&) -> Result<Done> { return Done{}; },  // see ViewSession::receive
        },
        message.content);
}

Result<Done> ViewSession::take_lights(const NamedLights& lights, const Message& message) {
    const std::optional<ShelfLight> first = shelf_.find(lights.first);
    if (!first) return Error{"", fmt::format("unknown light \"{}\"", lights.first)};
    ChooseLight edit;
    edit.light.image = first->image;
    edit.light.sky = first->sky;
    if (lights.second) {
        const std::optional<ShelfLight> second = shelf_.find(*lights.second);
        if (!second) return Error{"", fmt::format("unknown light \"{}\"", *lights.second)};
        edit.light.blend = BlendedLight{second->image, second->sky, lights.share};
    }
    HF_TRY_DONE(live_.lights().know(edit.light));
    return make_edit(edit, message, {Variation::Of::light, 0});
}

Result<Done> ViewSession::restore(const Message& message) {
    if (!left_) return Error{"", "there is no autosaved scene"};
    HF_TRY_DONE(live_.lights().know(left_->environment));
    HF_TRY_DONE(make_edit(RestoreScene{*left_}, message, {}));
    look_as_designed();
    decide_left_scene();
    return Done{};
}

/// A page has restored or discarded the autosaved scene of an earlier session.
void ViewSession::decide_left_scene() {
    left_.reset();
    for (const PageId page : pages_) tell_left_scene(page);
}

Result<Done> ViewSession::own_part(const EditPartMaterial& part, const Message& message) {
    const Design& now = history_.now();
    const std::optional<std::size_t> at = place_of(now, part.object);
    if (!at) return Error{"", fmt::format("unknown object {}", part.object)};
    const SceneEntity& entity = *live_.entities().entities[now.entities[*at]];
    if (part.part >= entity.surfaces.size())
        return Error{"", fmt::format("unknown part {} of this object", part.part)};
    const Surface& surface = entity.surfaces[part.part];
    const std::size_t described = now.scene.instances[*at].entity;
    const std::string& name = entity.mesh.fine.material_names[part.part];
    const Entity& description = now.scene.entities[described];
    if (!description.material.empty() || description.materials.contains(name))
        return Error{"", "this part already has a material of the scene"};
    if (surface.texture || surface.coloured)
        return Error{"",
                     "this part has the image or the vertex colours of its model, which a material of the "
                     "scene would replace"};
    return make_edit(MakeMaterialEditable{described, name, scene_material(surface)}, message, {});
}

Result<Done> ViewSession::take_place(const PartialPlace& place, const Message& message) {
    const std::optional<std::size_t> at = place_of(history_.now(), place.object);
    if (!at) return Error{"", fmt::format("unknown object {}", place.object)};
    Placement placement = history_.now().scene.instances[*at].placement;
    if (place.translate) placement.translate = *place.translate;
    if (place.scale) placement.scale = *place.scale;
    if (place.rotate) placement.rotate = *place.rotate;
    return make_edit(PlaceObject{place.object, placement}, message,
                     place.rotate ? Variation{} : Variation{Variation::Of::object, place.object});
}

Result<Done> ViewSession::take_look(const SetView& look, const Message& message) {
    window_ = look.camera;
    error_.reset();
    has_stepped_ = false;
    const Camera& now = history_.now().scene.camera;
    const bool has_moved = !is_same_place(look.camera.position, now.position, look.camera);
    const bool has_turned = !is_same_place(look.camera.target, now.target, look.camera);
    if (!has_moved && !has_turned) return Done{};
    const MoveEye edit{has_moved ? look.camera.position : now.position,
                       has_turned ? look.camera.target : now.target};
    HF_TRY_DONE(history_.make(edit, message.gesture));
    if (has_moved && has_specular_) likely_ = hand_ = {Variation::Of::eye, 0};
    return Done{};
}

/// Makes the page use the view of the design after undo or redo.
void ViewSession::look_as_designed() {
    const Camera& camera = history_.now().scene.camera;
    if (window_.position == camera.position && window_.target == camera.target) return;
    error_.reset();
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
