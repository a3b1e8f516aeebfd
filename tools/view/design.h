#pragma once
/// Edits of an open scene, with undo and redo.

#include "scenes/scene_entities.h"

#include <cstdint>
#include <variant>

namespace haarfield {

/// The current state of an edited scene.
///
/// Stamps identify contents: equal stamps mean equal contents. Undo restores the old stamp.
struct Design {
    Scene scene;                        ///< Its camera is the view of the steering page.
    std::vector<std::uint32_t> ids;     ///< By Scene::instances: the identifiers in messages. Never reused.
    std::vector<std::size_t> entities;  ///< By Scene::instances: index in SceneEntities::entities.
    std::uint64_t light_stamp = 0;      ///< Of scene.environment without `turn`, `exposure` and `share`.
    std::uint64_t material_stamp = 0;   ///< Of scene.materials and of their assignment.
    std::uint64_t lamp_stamp = 0;       ///< Of scene.lamps.
};

/// @name Edits
/// Changes of a design. Numbers are finite and in the ranges of the scene file: see read_edit.
/// @{

/// Rotates the environment, relative to its file.
struct TurnLight {
    Rotation turn;
};
/// Replaces the environment by another, or by a mixture of two.
struct ChooseLight {
    EnvironmentDescription light;  ///< Its image or sky, and the light that is blended with it.
};
/// Sets the fraction of the second of two mixed lights.
struct MixLights {
    float share;
};
struct SetExposure {
    std::optional<float> stops;  ///< None: automatic.
};
struct PlaceObject {
    std::uint32_t object;
    Placement placement;
};
/// Adds a copy of an object in the same place.
struct CloneObject {
    std::uint32_t object;
};
struct DeleteObject {
    std::uint32_t object;
};
/// Changes a material of the scene, except for its image.
struct SetMaterial {
    std::string name;
    SceneMaterial material;
};
/// Moves the eye and its target. Field of view and resolution are those of the scene.
struct MoveEye {
    Vec3f position, target;  ///< Must differ.
};
/// Changes the analytic sky that lights the scene.
struct SetSky {
    float turbidity;
    float sun_elevation, sun_azimuth;  ///< [rad]
};
/// Changes a lamp.
struct SetLamp {
    std::string name;
    Rgb colour;
    std::optional<Vec3f> position;  ///< None: unchanged.
};
/// Assigns a new material of the scene to a part of a model, starting as a copy of the model's own material.
struct MakeMaterialEditable {
    std::size_t entity;  ///< In Scene::entities.
    std::string part;    ///< The material's name in the model.
    SceneMaterial material;
};
/// Replaces everything but the meshes by a scene that an earlier session left behind.
struct RestoreScene {
    Scene scene;
};
using Edit =
    std::variant<TurnLight, ChooseLight, MixLights, SetExposure, PlaceObject, CloneObject, DeleteObject,
                 SetMaterial, MoveEye, SetSky, SetLamp, MakeMaterialEditable, RestoreScene>;
/// @}

/// The inputs of radiance in which two designs differ.
struct DesignDifference {
    bool environment = false;  ///< The light or the mixture, not its rotation.
    bool rotation = false;     ///< Of the environment.
    bool lamps = false, materials = false;
    bool objects = false;  ///< Another set of objects, or an object in another place.
    bool eye = false, exposure = false;

    bool scene() const { return environment || rotation || lamps || materials || objects; }
};

/// Compares two designs.
///
/// moving  an object whose translation and scale are ignored; 0: none.
DesignDifference difference(const Design& a, const Design& b, std::uint32_t moving = 0);

/// The fraction of the second light in a design's environment; 0 if there is none.
float second_share(const Design& design);

/// Returns the design of a newly opened scene, with new ids.
Design opened_design(const Scene& scene, const SceneEntities& entities);

/// Tests whether two scenes differ in more than the camera.
bool is_changed(const Scene& scene, const Scene& from);

/// Returns the index of an object in Scene::instances; none if the object does not exist.
std::optional<std::size_t> place_of(const Design& design, std::uint32_t object);

/// The designs of a scene in sequence, for undo and redo.
class History {
public:
    explicit History(Design start) : now_(std::move(start)), next_id_(highest_id() + 1) {}

    const Design& now() const { return now_; }
    bool can_undo() const { return !before_.empty(); }
    bool can_redo() const { return !after_.empty(); }

    /// Applies an edit. Edits of one gesture are undone together.
    ///
    /// gesture  consecutive edits with the same number belong to one gesture; 0: a single edit.
    /// errors   unknown object, material or lamp; no second light or no sky to change; deletion of the last
    ///          object; an autosaved scene with other meshes. The design is then unchanged.
    Result<Done> make(const Edit& edit, std::uint64_t gesture);

    bool undo();  ///< Returns false if there is nothing to undo.
    bool redo();  ///< Returns false if there is nothing to redo.

    /// Ends the current gesture, even if the next edit has the same number, because another page makes it.
    void end_gesture() { gesture_ = 0; }

private:
    std::uint32_t highest_id() const;
    void step_to(std::vector<Design>& from, std::vector<Design>& to);

    Design now_;
    std::vector<Design> before_, after_;
    std::uint64_t gesture_ = 0;
    std::uint64_t last_stamp_ = 0;
    std::uint32_t next_id_;
};

}  // namespace haarfield
