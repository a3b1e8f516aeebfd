#pragma once
/// The description of a scene, in metres and radians. Scene files (TOML) use degrees.

#include "fields/base/vector.h"
#include "fields/mesh/closed_pieces.h"
#include "fields/preparation/mesh_preparation.h"
#include "scenes/reflection.h"
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

/// A pinhole camera; +y is up in the picture.
struct Camera {
    Vec3f position{0, 1, 5};
    Vec3f target{0, 0, 0};
    float vertical_fov = 0.6108652f;  ///< Full angle. [rad]
    int width = 640, height = 480;    ///< [pixels]
};

/// A second environment, mixed with the first.
struct BlendedLight {
    std::filesystem::path image;  ///< Lat-long; empty if `sky` is set.
    std::optional<AnalyticSky> sky;
    float share = 0.5f;  ///< Weight of the second environment, in [0, 1]; the first has 1 - share.
};

/// The environment: an image, an analytic sky, or black.
struct EnvironmentDescription {
    std::filesystem::path image;  ///< Lat-long; empty if `sky` is set, or the environment is black.
    std::optional<AnalyticSky> sky;
    float rotation = 0;                    ///< About +y, see turned_environment. [rad]
    std::optional<float> exposure = 0.0f;  ///< None: found_exposure. [stops]
    std::optional<BlendedLight> blend{};   ///< Rotated and exposed like the first.
    bool lights = true;  ///< False: pictures show it behind the objects, and it lights nothing.
    Rotation turn{};     ///< Applied after `rotation`; the file's `rotate` is rotation_xyz.

    bool is_black() const { return image.empty() && !sky; }  ///< True if there is no environment.
};

/// A material of the scene file.
struct SceneMaterial : Material {
    std::filesystem::path image;  ///< Multiplies diffuse reflection and emission; empty: none.
    /// The mesh's vertex colours, if it has any, multiply diffuse reflection and emission.
    bool vertex_colours = false;
    Reflection reflection{};  ///< Of other objects and the environment, when POV-Ray renders a bake.
    Rgb emission{0, 0, 0};    ///< Emitted radiance; it lights other surfaces. [W/(m^2 sr)]
    Rgb ambient{0, 0, 0};     ///< Additional radiance that lights nothing. [W/(m^2 sr)]

    bool emits() const { return emission != Rgb(0.0f); }  ///< True for emitters.
};

/// A mesh with its materials, and the parameters of its preparation.
struct Entity {
    std::string name;
    std::filesystem::path mesh;
    std::string part;  ///< Name of a part of the file (ModelParts), in the part's own frame; empty: the whole
                       ///< file.
    /// Material of everything that `materials` does not name; empty: the materials of the mesh file.
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
    std::string name;        ///< From the file, or the entity's name, numbered if it has several instances:
                             ///< `chair_2`.
    std::size_t entity = 0;  ///< Index in Scene::entities.
    Placement placement;     ///< The file's `rotate` is rotation_xyz.
    Shape shape{};           ///< Of the mesh, before the placement.
};

/// A lamp of the scene; Lamp::looks_like is an index in Scene::instances.
struct SceneLamp : Lamp {
    std::string name;  ///< Unique.
};

/// Returns the lamps without their names, for shading.
std::vector<Lamp> lamps_of(std::span<const SceneLamp> lamps);

/// The placement of an instance at one time of an animation. An absent value is interpolated between the
/// instance's other keyframes.
struct Keyframe {
    float time = 0;                  ///< From 0, where all is as the instances describe. [s]
    std::size_t instance = 0;        ///< Index in Scene::instances.
    std::optional<Vec3f> translate;  ///< Replaces the placement's translation. [m]
    std::optional<Vec3f> rotate;     ///< Rotation in addition to the placement's, as angles of rotation_xyz.
                                     ///< [rad]
    std::optional<float> scale;      ///< Factor on the placement's scale; > 0.
};

/// A lamp at one time of an animation. An absent value is interpolated between the lamp's other keyframes.
struct LampKeyframe {
    float time = 0;                                 ///< From 0, where all is as the lamps describe. [s]
    std::size_t lamp = 0;                           ///< Index in Scene::lamps.
    std::optional<Vec3f> position, target, colour;  ///< As in Lamp.
};

/// The POV-Ray scene in which the objects of a scene stand. Its units are the scene's metres.
struct Surroundings {
    std::filesystem::path file;  ///< The scene in POV-Ray's language.
    bool z_up = false;           ///< Its z axis points up, else y.
    bool left_handed = true;     ///< Its coordinates, as POV-Ray's camera usually shows them.
    /// Another folder in which POV-Ray finds includes and images; empty: none.
    std::filesystem::path folder{};
};

/// A transparent object that filters the light of lamps. It is not baked, and other light ignores it.
struct SceneFilter {
    std::filesystem::path mesh;   ///< In the scene's coordinates.
    Rgb colour{1.0f};             ///< Fraction of light that passes each of its surfaces, in [0, 1].
    bool vertex_colours = false;  ///< The mesh's vertex colours multiply `colour`.
    Rgb absorption{0.0f};         ///< Absorption coefficient inside the object; >= 0. [1/m]
};

struct FilesInMemory;

/// A whole scene.
struct Scene {
    std::string name;  ///< The file's name without its extension.
    Camera camera;
    bool finds_camera = false;  ///< The camera's position and target are to be chosen by scene_camera.
    EnvironmentDescription environment;
    std::map<std::string, SceneMaterial> materials;
    std::vector<Entity> entities;              ///< In the order of the file.
    std::vector<Instance> instances;           ///< In the order of the file.
    std::vector<SceneLamp> lamps;              ///< In the order of the file.
    std::vector<SceneFilter> filters;          ///< In the order of the file.
    std::vector<Keyframe> keyframes;           ///< In the order of the file; times of one instance increase.
    std::vector<LampKeyframe> lamp_keyframes;  ///< In the order of the file; times of one lamp increase.
    /// POV-Ray's assumed_gamma: light, pigments and vertex colours are numbers whose powers by it are linear
    /// light. Images are linear light. POV-Ray's pictures of the scene respect it, no other picture does.
    float assumed_gamma = 1;
    std::optional<int> bounces;  ///< Of indirect light, unless options say otherwise; none: no limit.
    std::optional<Surroundings> surroundings;  ///< None: the objects belong to no other scene.
    /// Data that a program supplies in place of files of the scene; null: none. See files_in_memory.h.
    std::shared_ptr<const FilesInMemory> given;

    /// Tests whether a material emits light.
    bool emits() const {
        return std::ranges::any_of(materials, [](const auto& named) { return named.second.emits(); });
    }
};

}  // namespace haarfield
