#include "tools/view/design.h"

#include "fields/base/names.h"

#include <fmt/format.h>

#include <algorithm>

namespace haarfield {
namespace {

constexpr std::size_t most_steps = 500;  ///< That can be taken back.

Error no_object(std::uint32_t object) {
    return Error{"", fmt::format("there is no object {}", object)};
}

/// The name without a number behind it, so that copies of copies do not grow `_2_2`.
std::string without_number(const std::string& name) {
    const std::size_t bar = name.find_last_of('_');
    if (bar == std::string::npos || bar == 0 || bar + 1 == name.size()) return name;
    const bool is_number = std::all_of(name.begin() + static_cast<std::ptrdiff_t>(bar) + 1, name.end(),
                                       [](unsigned char c) { return c >= '0' && c <= '9'; });
    return is_number ? name.substr(0, bar) : name;
}

std::string copy_name(const Scene& scene, const std::string& name) {
    std::set<std::string> taken;
    for (const Instance& instance : scene.instances) taken.insert(instance.name);
    for (const Entity& entity : scene.entities) taken.insert(entity.name);
    return unique_name(without_number(name), taken);
}

/// Makes an edit of a design; what it changes in part is of no use if it fails.
struct EditMaker {
    Design& design;
    std::uint64_t stamp;
    std::uint32_t id;

    Result<Done> operator()(const TurnLight& edit) {
        design.scene.environment.turn = edit.turn;
        return Done{};
    }

    Result<Done> operator()(const ChooseLight& edit) {
        EnvironmentDescription& now = design.scene.environment;
        now.image = edit.light.image;
        now.sky = edit.light.sky;
        now.blend = edit.light.blend;
        design.light_stamp = stamp;
        return Done{};
    }

    Result<Done> operator()(const MixLights& edit) {
        if (!design.scene.environment.blend) return Error{"", "there is one light; wanted two to be mixed"};
        design.scene.environment.blend->share = edit.share;
        return Done{};
    }

    Result<Done> operator()(const SetExposure& edit) {
        design.scene.environment.exposure = edit.stops;
        return Done{};
    }

    Result<Done> operator()(const PlaceObject& edit) {
        const std::optional<std::size_t> place = place_of(design, edit.object);
        if (!place) return no_object(edit.object);
        design.scene.instances[*place].placement = edit.placement;
        return Done{};
    }

    Result<Done> operator()(const CloneObject& edit) {
        const std::optional<std::size_t> place = place_of(design, edit.object);
        if (!place) return no_object(edit.object);
        Instance copy = design.scene.instances[*place];
        copy.name = copy_name(design.scene, copy.name);
        design.scene.instances.push_back(std::move(copy));
        design.ids.push_back(id);
        design.entities.push_back(std::size_t(design.entities[*place]));
        return Done{};
    }

    Result<Done> operator()(const DeleteObject& edit) {
        const std::optional<std::size_t> place = place_of(design, edit.object);
        if (!place) return no_object(edit.object);
        if (design.ids.size() == 1) return Error{"", "it is the last object; wanted at least one in a scene"};
        const auto at = static_cast<std::ptrdiff_t>(*place);
        Scene& scene = design.scene;
        scene.instances.erase(scene.instances.begin() + at);
        design.ids.erase(design.ids.begin() + at);
        design.entities.erase(design.entities.begin() + at);
        std::erase_if(scene.keyframes, [&](const Keyframe& keyframe) { return keyframe.instance == *place; });
        for (Keyframe& keyframe : scene.keyframes)
            if (keyframe.instance > *place) --keyframe.instance;
        for (SceneLamp& lamp : scene.lamps) {
            if (lamp.looks_like == *place) lamp.looks_like.reset();
            if (lamp.looks_like && *lamp.looks_like > *place) --*lamp.looks_like;
        }
        return Done{};
    }

    Result<Done> operator()(const SetMaterial& edit) {
        const auto known = design.scene.materials.find(edit.name);
        if (known == design.scene.materials.end())
            return Error{"", fmt::format("there is no material \"{}\" in the scene", edit.name)};
        const std::filesystem::path image = known->second.image;
        known->second = edit.material;
        known->second.image = image;
        design.material_stamp = stamp;
        return Done{};
    }

    Result<Done> operator()(const MoveEye& edit) {
        design.scene.camera.position = edit.position;
        design.scene.camera.target = edit.target;
        return Done{};
    }
};

}  // namespace

Design opened_design(const Scene& scene, const SceneEntities& entities) {
    Design design{scene, {}, entities.entity_of_instance};
    // One turn is enough, and turning twice would blur the light twice.
    EnvironmentDescription& light = design.scene.environment;
    if (light.rotation != 0) light.turn = light.turn * rotation_about({0, 1, 0}, double(light.rotation));
    light.rotation = 0;
    for (std::size_t i = 0; i < scene.instances.size(); ++i)
        design.ids.push_back(static_cast<std::uint32_t>(i + 1));
    return design;
}

std::optional<std::size_t> place_of(const Design& design, std::uint32_t object) {
    const auto found = std::ranges::find(design.ids, object);
    if (found == design.ids.end()) return std::nullopt;
    return static_cast<std::size_t>(found - design.ids.begin());
}

std::uint32_t History::highest_id() const {
    return now_.ids.empty() ? 0 : *std::ranges::max_element(now_.ids);
}

Result<Done> History::make(const Edit& edit, std::uint64_t gesture) {
    Design made = now_;
    if (const Result<Done> done = std::visit(EditMaker{made, last_stamp_ + 1, next_id_}, edit); !done)
        return done;
    ++last_stamp_;
    if (std::holds_alternative<CloneObject>(edit)) ++next_id_;
    const bool goes_on = gesture != 0 && gesture == gesture_ && can_undo();
    if (!goes_on) {
        before_.push_back(std::move(now_));
        if (before_.size() > most_steps) before_.erase(before_.begin());
    }
    gesture_ = gesture;
    after_.clear();
    now_ = std::move(made);
    return Done{};
}

void History::step_to(std::vector<Design>& from, std::vector<Design>& to) {
    to.push_back(std::move(now_));
    now_ = std::move(from.back());
    from.pop_back();
    end_gesture();
}

bool History::undo() {
    if (!can_undo()) return false;
    step_to(before_, after_);
    return true;
}

bool History::redo() {
    if (!can_redo()) return false;
    step_to(after_, before_);
    return true;
}

}  // namespace haarfield
