#pragma once
/// What a person changes by hand in a scene that is open, and how it is taken back.

#include "scenes/scene_entities.h"

#include <cstdint>
#include <variant>

namespace haarfield {

/// A scene as it stands now.
///
/// Stamps tell contents apart: equal stamps, equal contents; what is undone gets its old stamp back.
struct Design {
    Scene scene;                        ///< Its camera is where the steering page looks from.
    std::vector<std::uint32_t> ids;     ///< By Scene::instances: what messages call them. Never used twice.
    std::vector<std::size_t> entities;  ///< By Scene::instances: place in SceneEntities::entities.
    std::uint64_t light_stamp = 0;      ///< Of scene.environment without `turn`, `exposure` and `share`.
    std::uint64_t material_stamp = 0;   ///< Of scene.materials and of who has which.
    std::uint64_t lamp_stamp = 0;       ///< Of scene.lamps.
};

/// @name Edits
/// What hands do. Numbers are finite and in the ranges of the scene file: see read_edit.
/// @{

/// Turns the environment, as it stands in its file, by a rotation.
struct TurnLight {
    Rotation turn;
};
/// Exchanges the environment, or mixes two.
struct ChooseLight {
    EnvironmentDescription light;  ///< Its image or sky, and what is blended with it.
};
/// How much of the second light there is, where two are mixed.
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
/// A copy beside the object.
struct CloneObject {
    std::uint32_t object;
};
struct DeleteObject {
    std::uint32_t object;
};
/// Exchanges a material of the scene, but for its image.
struct SetMaterial {
    std::string name;
    SceneMaterial material;
};
/// Moves the eye, and what it looks at; the angle and the picture's size are the scene's.
struct MoveEye {
    Vec3f position, target;  ///< In different places.
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
    std::optional<Vec3f> position;  ///< None: it stays.
};
/// Gives a part of a model a material of the scene, which begins as a copy of the model's own.
struct OwnMaterial {
    std::size_t entity;  ///< In Scene::entities.
    std::string part;    ///< The material's name in the model.
    SceneMaterial material;
};
/// Replaces everything but the meshes by a scene that an earlier session has left.
struct RestoreScene {
    Scene scene;
};
using Edit = std::variant<TurnLight, ChooseLight, MixLights, SetExposure, PlaceObject, CloneObject,
                          DeleteObject, SetMaterial, MoveEye, SetSky, SetLamp, OwnMaterial, RestoreScene>;
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

/// A scene that is opened, with new ids.
Design opened_design(const Scene& scene, const SceneEntities& entities);

/// Tests whether two scenes differ in more than the camera.
bool is_changed(const Scene& scene, const Scene& from);

/// The place of an object in Scene::instances; none if there is no such object.
std::optional<std::size_t> place_of(const Design& design, std::uint32_t object);

/// The scene's designs, one step after another.
class History {
public:
    explicit History(Design start) : now_(std::move(start)), next_id_(highest_id() + 1) {}

    const Design& now() const { return now_; }
    bool can_undo() const { return !before_.empty(); }
    bool can_redo() const { return !after_.empty(); }

    /// Makes an edit. Edits of one gesture are undone together.
    ///
    /// gesture  the edits of one gesture follow each other and have the same number; 0: one edit alone.
    /// entities of the scene.
    /// errors   no such object, material or second light; the last object would be deleted; what the scene
    ///          file can not say. Then nothing has changed.
    Result<Done> make(const Edit& edit, std::uint64_t gesture);

    bool undo();  ///< False if there is nothing to take back.
    bool redo();  ///< False if there is nothing to do again.

    /// What follows is another gesture, whatever its number: that of another hand.
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
