#pragma once
/// Scenes from models.

#include "fields/base/progress.h"
#include "fields/base/result.h"
#include "scenes/scene.h"

#include <span>

namespace haarfield {

/// What becomes of models.
struct SceneImport {
    bool whole = false;  ///< One entity for each file, whatever its parts are.
    bool z_up = false;   ///< The models' z is up: they are turned about x, so that it becomes y.
    double unit = 1;     ///< What a model's unit is. [m], > 0.
    /// Scales all of the models alike, so that the longest side of the box round them is this, instead of
    /// `unit`. [m], > 0.
    std::optional<double> size{};
    bool floor = false;        ///< Puts a floor below them that reaches to the horizon.
    bool keep_places = false;  ///< Models of several files stay where their files place them.
    /// Lat-long image that lights the scene instead of a clear sky; empty: none.
    std::filesystem::path environment{};
    bool no_environment = false;  ///< Only the lights of the files light the scene.
    /// Vertices to be baked, of all instances together, shared out by the area of their surfaces.
    std::uint32_t vertices = 150000;
};

/// A scene, and the floor's mesh if one is wanted.
struct ImportedScene {
    Scene scene;
    std::string floor_obj;  ///< The text of the file that the floor's entities name; empty: no floor.
    std::vector<std::string> warnings;
};

/// Makes a scene of models, lit by the lights of their files and by a clear sky with the sun at 40 degrees,
/// with the exposure found. POV-Ray's lights are the only ones of their scenes: these get no sky. Lights in
/// photometric units are scaled, with a warning, if they light a white sphere (albedo 0.8) amid the models to
/// a radiance above 1, or if the models are in a closed room.
///
/// Left-handed coordinates of POV-Ray files (ModelFile::is_left_handed) become right-handed: the instances
/// and lights of such a file are mirrored, so that a picture shows the models as POV-Ray does.
///
/// Models of several files whose boxes overlap are placed side by side along x, on one level, with a warning.
///
/// The floor has three entities: `floor`, a square that reaches 0.8 times the models' longest side to each
/// side and has vertices close enough for shadows at the models' feet; `apron`, around it, twice the longest
/// side to each side; and `ground`, which surrounds both as far as the horizon. All have the albedo that
/// makes them as bright as the environment below the horizon.
///
/// If one room encloses all models, and no file has a camera, the camera stands inside the room. The room may
/// have windows and doors if its triangles face inwards and surround a place from most sides, with level
/// floor and vertical walls. If nothing emits light in a room without openings, a lamp is added below the
/// ceiling, with a warning.
///
/// A part of a file (ModelParts) becomes an entity, of which each of the file's nodes is an instance. A file
/// whose parts stand where they are and none twice, as in OBJ and PLY, becomes one entity. All have the
/// files' own materials. The camera is the first that a file has, or is to be found (Scene::finds_camera).
///
/// An entity with rooms (closed_pieces.h) faces inwards: objects, lights and cameras of all files count as
/// what a room encloses.
///
/// folder  where the scene will be; there lies `floor.obj`.
/// errors  as ModelFile::open and read_mesh; a place that linear_parts refuses; nothing with a surface.
/// cost    reads each file once.
Result<ImportedScene> scene_of_models(std::span<const std::filesystem::path> files,
                                      const std::filesystem::path& folder, const SceneImport& wanted,
                                      const Progress& progress = {});

}  // namespace haarfield
