#include "tools/view/scene_editor.h"

#include "scenes/povray_finish.h"
#include "tools/view/view_job.h"

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

}  // namespace

SceneEditor::SceneEditor(const Scene& scene, const std::filesystem::path& file, LiveScene& live,
                         const LightShelf& shelf, const SessionPages& pages)
    : live_(live),
      shelf_(shelf),
      pages_(pages),
      history_(opened_design(scene, live.entities())),
      file_(file),
      window_(scene.camera) {}

Result<WindowChange> SceneEditor::make_edit(const Edit& edit, const Message& message, const Variation& hand) {
    HF_TRY_DONE(history_.make(edit, message.gesture));
    hand_ = hand;
    if (hand.of != Variation::Of::nothing) likely_ = hand;
    return WindowChange::none;
}

Result<WindowChange> SceneEditor::take_lights(const NamedLights& lights, const Message& message) {
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

Result<WindowChange> SceneEditor::own_part(const EditPartMaterial& part, const Message& message) {
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

Result<WindowChange> SceneEditor::take_look(const SetView& look, const Message& message) {
    window_ = look.camera;
    const Camera& now = history_.now().scene.camera;
    const bool has_moved = !is_same_place(look.camera.position, now.position, look.camera);
    const bool has_turned = !is_same_place(look.camera.target, now.target, look.camera);
    if (!has_moved && !has_turned) return WindowChange::by_page;
    const MoveEye edit{has_moved ? look.camera.position : now.position,
                       has_turned ? look.camera.target : now.target};
    HF_TRY_DONE(history_.make(edit, message.gesture));
    if (has_moved && live_.has_specular()) likely_ = hand_ = {Variation::Of::eye, 0};
    return WindowChange::by_page;
}

/// Makes the page use the view of the design after undo or redo.
WindowChange SceneEditor::look_as_designed() {
    const Camera& camera = history_.now().scene.camera;
    if (window_.position == camera.position && window_.target == camera.target) return WindowChange::none;
    window_.position = camera.position;
    window_.target = camera.target;
    return WindowChange::by_step;
}

Result<WindowChange> SceneEditor::save(PageId page, const Save& save, const Message& message) {
    HF_TRY(const SavedScene saved, file_.save(history_.now().scene, save.name.value_or("")));
    saved_ = history_.now().scene;
    if (!left_ && !file_.opened().empty()) HF_TRY_DONE(file_.autosave(nullptr));
    autosaved_ = saved_;
    nlohmann::json answer{{"type", "saved"}, {"number", message.number}, {"file", saved.file.string()}};
    if (!saved.instead_of.empty()) answer["instead_of"] = saved.instead_of.string();
    pages_.tell(page, message_text(answer));
    return WindowChange::none;
}

void SceneEditor::read_left_scene() {
    if (const std::optional<Result<Scene>> left = file_.left_scene(); left && *left) left_ = **left;
}

void SceneEditor::autosave() {
    const Scene& now = history_.now().scene;
    // The autosave of an earlier session remains until a page decides.
    if (left_ || file_.opened().empty() || !is_changed(now, autosaved_)) return;
    autosaved_ = now;
    const Result<Done> done = file_.autosave(is_changed(now, saved_) ? &now : nullptr);
    if (!done && !autosave_has_failed_) pages_.tell_all(message_text(error_answer(done.error(), {})));
    autosave_has_failed_ = !done;
}

}  // namespace haarfield
