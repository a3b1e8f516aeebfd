#pragma once
/// A scene as its author writes it, in metres and radians; its file, in TOML, has degrees.

#include "fields/base/vector.h"
#include "fields/mesh/closed_pieces.h"
#include "fields/preparation/mesh_preparation.h"
#include "scenes/shape.h"
#include "shading/scene/lamp.h"
#include "shading/scene/material.h"
#include "shading/scene/sky.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace haarfield {

/// A pinhole camera; +y is up in its picture.
struct Camera {
    Vec3f position{0, 1, 5};
    Vec3f target{0, 0, 0};
    float vertical_fov = 0.6108652f;  ///< Full angle. [rad]
    int width = 640, height = 480;    ///< [pixels]
};

/// A second light, mixed with the first.
struct BlendedLight {
    std::filesystem::path image;  ///< Lat-long; empty if `sky` is set.
    std::optional<AnalyticSky> sky;
    float share = 0.5f;  ///< Of the second light, in [0, 1]; the first has the rest.
};

/// An image, or a sky, or black.
struct EnvironmentDescription {
    std::filesystem::path image;  ///< Lat-long; empty if `sky` is set, or there is no light from afar.
    std::optional<AnalyticSky> sky;
    float rotation = 0;                    ///< About +y, see turned_environment. [rad]
    std::optional<float> exposure = 0.0f;  ///< None: found_exposure. [stops]
    std::optional<BlendedLight> blend{};   ///< Turned and exposed alike.
    Rotation turn{};                       ///< After `rotation`; the file's `rotate` is rotation_xyz.

    bool is_black() const { return image.empty() && !sky; }
};

/// A material as the scene describes it.
struct SceneMaterial : Material {
    std::filesystem::path image;  ///< Multiplies what is diffuse, and the emission; empty: none.
    Rgb emission{0, 0, 0};        ///< Radiance of its own; it lights others. [W/(m^2 sr)]

    bool glows() const { return emission != Rgb(0.0f); }
};

/// One kind of object, and how it is prepared.
struct Entity {
    std::string name;
    std::filesystem::path mesh;
    std::string part;  ///< Of the file, by its name (ModelParts), in its own frame; empty: all, as it stands.
    /// Of everything that `materials` does not name; empty: as the mesh's file has it.
    std::string material;
    std::map<std::string, std::string> materials;  ///< By the material's name in the mesh file.
    ClosedFaces faces = ClosedFaces::outwards;     ///< The visible side of closed pieces.
    std::uint32_t fine_vertices = 25000;
    std::uint32_t coarse_triangles = chosen_by_distance;  ///< 0: all triangles of the file.
    std::uint32_t planar_samples = 20000;
    std::uint32_t spherical_samples = 10000;
};

/// One object of the scene.
struct Instance {
    std::string name;        ///< Its own, or the entity's, with a number if that has several: `chair_2`.
    std::size_t entity = 0;  ///< Index in Scene::entities.
    Placement placement;     ///< The file's `rotate` is rotation_xyz.
    Shape shape{};           ///< Of its mesh, before it is placed.
};

/// A lamp of the scene; Lamp::looks_like is an index in Scene::instances.
struct SceneLamp : Lamp {
    std::string name;  ///< Unlike all others.
};

/// The same without their names, as shading takes them.
std::vector<Lamp> lamps_of(std::span<const SceneLamp> lamps);

/// Where an instance is at one time of a film; of what is not given, see its keyframes before and after.
struct Keyframe {
    float time = 0;                  ///< From 0, when all is as the instances say. [s]
    std::size_t instance = 0;        ///< Index in Scene::instances.
    std::optional<Vec3f> translate;  ///< Of its placement then. [m]
    std::optional<Vec3f> rotate;  ///< Angles by which it is turned beyond its placement: rotation_xyz. [rad]
    std::optional<float> scale;   ///< How many times as large as by its placement it is; > 0.
};

/// What a lamp is at one time of a film; of what is not given, see its keyframes before and after.
struct LampKeyframe {
    float time = 0;                                 ///< From 0, when all is as the lamps say. [s]
    std::size_t lamp = 0;                           ///< Index in Scene::lamps.
    std::optional<Vec3f> position, target, colour;  ///< As in Lamp.
};

struct GivenFiles;

/// A whole scene.
struct Scene {
    std::string name;  ///< The file's, without its ending.
    Camera camera;
    bool finds_camera = false;  ///< The camera's position and target are not known: see scene_camera.
    EnvironmentDescription environment;
    std::map<std::string, SceneMaterial> materials;
    std::vector<Entity> entities;              ///< In the order of the file.
    std::vector<Instance> instances;           ///< In the order of the file.
    std::vector<SceneLamp> lamps;              ///< In the order of the file.
    std::vector<Keyframe> keyframes;           ///< In the order of the file; times of one instance grow.
    std::vector<LampKeyframe> lamp_keyframes;  ///< The same of lamps.
    /// What a program gives in place of files that the scene names; null: nothing. See given_files.h.
    std::shared_ptr<const GivenFiles> given;

    /// Whether a material does.
    bool glows() const {
        return std::ranges::any_of(materials, [](const auto& named) { return named.second.glows(); });
    }
};

}  // namespace haarfield
