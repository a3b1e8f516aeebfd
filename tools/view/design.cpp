#include "tools/view/design.h"

#include "fields/base/names.h"
#include "scenes/scene_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace haarfield {
namespace {

constexpr std::size_t most_steps = 500;  ///< That can be undone.

Error no_object(std::uint32_t object) {
    return Error{"", fmt::format("unknown object {}", object)};
}

/// Returns the name without a trailing number, so that copies of copies are not named `_2_2`.
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

/// Returns an environment whose rotation is part of `turn`. Two separate rotations would blur the light
/// twice.
EnvironmentDescription turned_once(EnvironmentDescription light) {
    if (light.rotation != 0) light.turn = light.turn * rotation_about({0, 1, 0}, double(light.rotation));
    light.rotation = 0;
    return light;
}

bool has_same_mesh(const Entity& a, const Entity& b) {
    std::error_code ignored;
    const bool is_one_file = a.mesh == b.mesh || std::filesystem::equivalent(a.mesh, b.mesh, ignored);
    return a.name == b.name && is_one_file && a.part == b.part && a.faces == b.faces &&
           a.fine_vertices == b.fine_vertices && a.coarse_triangles == b.coarse_triangles &&
           a.planar_samples == b.planar_samples && a.spherical_samples == b.spherical_samples;
}

/// Applies an edit to a design. A failed edit may leave the design partly changed; the caller discards it.
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
        if (!design.scene.environment.blend) return Error{"", "the scene has one light; mixing expects two"};
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
        if (design.ids.size() == 1)
            return Error{"", "this is the last object; expected at least one object in a scene"};
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
            return Error{"", fmt::format("unknown material \"{}\"", edit.name)};
        const std::filesystem::path image = known->second.image;
        known->second = edit.material;
        known->second.image = image;
        design.material_stamp = stamp;
        return Done{};
    }

    Result<Done> operator()(const SetSky& edit) {
        std::optional<AnalyticSky>& sky = design.scene.environment.sky;
        if (!sky) return Error{"", "the scene is lit by an image; expected an analytic sky"};
        sky->turbidity = edit.turbidity;
        sky->sun_elevation = edit.sun_elevation;
        sky->sun_azimuth = edit.sun_azimuth;
        design.light_stamp = stamp;
        return Done{};
    }

    Result<Done> operator()(const SetLamp& edit) {
        const auto lamp = std::ranges::find(design.scene.lamps, edit.name, &SceneLamp::name);
        if (lamp == design.scene.lamps.end()) return Error{"", fmt::format("unknown lamp \"{}\"", edit.name)};
        lamp->colour = edit.colour;
        if (edit.position) lamp->position = *edit.position;
        design.lamp_stamp = stamp;
        return Done{};
    }

    Result<Done> operator()(const MakeMaterialEditable& edit) {
        Scene& scene = design.scene;
        Entity& entity = scene.entities[edit.entity];
        std::set<std::string> taken;
        for (const auto& [name, material] : scene.materials) taken.insert(name);
        const std::string name =
            unique_name(plain_name(edit.part.empty() ? entity.name : entity.name + "_" + edit.part), taken);
        scene.materials[name] = edit.material;
        entity.materials[edit.part] = name;
        design.material_stamp = stamp;
        return Done{};
    }

    Result<Done> operator()(const RestoreScene& edit) {
        const Scene& now = design.scene;
        std::vector<std::size_t> entities;
        for (const Instance& instance : edit.scene.instances) {
            const std::optional<std::size_t> mesh = mesh_of(instance, edit.scene);
            if (!mesh)
                return Error{
                    "", fmt::format("the autosaved scene has a different mesh or shape for the object \"{}\" "
                                    "of {}",
                                    instance.name, now.name)};
            entities.push_back(*mesh);
        }
        Scene restored = edit.scene;
        restored.name = now.name;
        restored.environment = turned_once(restored.environment);
        design.scene = std::move(restored);
        design.entities = std::move(entities);
        design.ids.resize(design.entities.size());
        std::iota(design.ids.begin(), design.ids.end(), id);
        design.light_stamp = design.material_stamp = design.lamp_stamp = stamp;
        return Done{};
    }

    /// Returns the prepared mesh for an instance of another scene: that of an instance here with the same
    /// entity and shape.
    std::optional<std::size_t> mesh_of(const Instance& instance, const Scene& other) const {
        const Scene& now = design.scene;
        if (instance.entity >= now.entities.size() ||
            !has_same_mesh(now.entities[instance.entity], other.entities[instance.entity]))
            return std::nullopt;
        for (std::size_t i = 0; i < now.instances.size(); ++i)
            if (now.instances[i].entity == instance.entity && now.instances[i].shape == instance.shape)
                return design.entities[i];
        return std::nullopt;
    }

    Result<Done> operator()(const MoveEye& edit) {
        design.scene.camera.position = edit.position;
        design.scene.camera.target = edit.target;
        return Done{};
    }
};

}  // namespace

float second_share(const Design& design) {
    return design.scene.environment.blend ? design.scene.environment.blend->share : 0;
}

DesignDifference difference(const Design& a, const Design& b, std::uint32_t moving) {
    DesignDifference found;
    const EnvironmentDescription &one = a.scene.environment, &other = b.scene.environment;
    found.environment = a.light_stamp != b.light_stamp || second_share(a) != second_share(b);
    found.rotation = one.turn != other.turn;
    found.lamps = a.lamp_stamp != b.lamp_stamp;
    found.materials = a.material_stamp != b.material_stamp;
    found.objects = a.ids != b.ids || a.entities != b.entities;
    for (std::size_t i = 0; i < a.ids.size() && !found.objects; ++i) {
        const Placement &before = a.scene.instances[i].placement, &now = b.scene.instances[i].placement;
        found.objects = a.ids[i] == moving ? before.rotate != now.rotate : before != now;
    }
    found.eye = a.scene.camera.position != b.scene.camera.position;
    found.exposure = one.exposure != other.exposure;
    return found;
}

Design opened_design(const Scene& scene, const SceneEntities& entities) {
    Design design{scene, {}, entities.entity_of_instance};
    design.scene.environment = turned_once(design.scene.environment);
    for (std::size_t i = 0; i < scene.instances.size(); ++i)
        design.ids.push_back(static_cast<std::uint32_t>(i + 1));
    return design;
}

bool is_changed(const Scene& scene, const Scene& from) {
    Scene seen_alike = scene;
    seen_alike.camera = from.camera;
    return scene_text(seen_alike, {}) != scene_text(from, {});
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
    HF_TRY_DONE(std::visit(EditMaker{made, last_stamp_ + 1, next_id_}, edit));
    ++last_stamp_;
    next_id_ = std::max(next_id_, made.ids.back() + 1);
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
