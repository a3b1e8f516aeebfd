#pragma once
/// Creates scenes from model files.

#include "fields/base/affine_map.h"
#include "fields/base/progress.h"
#include "fields/base/result.h"
#include "fields/model/model_part.h"
#include "scenes/scene.h"

#include <span>

namespace haarfield {

/// Options of an import.
struct SceneImport {
    bool whole = false;  ///< Creates one entity per file, regardless of its parts.
    bool z_up = false;   ///< The models' z axis points up: they are rotated about x so that it becomes y.
    double unit = 1;     ///< Length of a model's unit. [m], > 0.
    /// If set, replaces `unit`: all models are scaled by one factor so that the longest side of their common
    /// box has this length. [m], > 0.
    std::optional<double> size{};
    bool floor = false;        ///< Adds a floor below the models that extends to the horizon.
    bool keep_places = false;  ///< Leaves models of several files where their files place them.
    /// If set, moves all models together: the middle of the bottom of their common box is here. [m]
    std::optional<Vec3d> stand_at{};
    /// Lat-long image that lights the scene in place of a clear sky; empty: none.
    std::filesystem::path environment{};
    bool no_environment = false;  ///< Only the lights of the files light the scene.
    /// Vertices to be baked over all instances, distributed by surface area.
    std::uint32_t vertices = 150000;
};

/// A scene, and the floor's mesh if requested.
struct ImportedScene {
    Scene scene;
    std::string floor_obj;  ///< Text of the OBJ file that the floor's entities name; empty: no floor.
    std::vector<std::string> warnings;
    Bounds bounds;  ///< Of all models, without the floor.
};

/// Returns the rotation or reflection from a file's coordinates to a right-handed frame with y up.
/// Left-handed coordinates become right-handed by negating depth.
///
/// z_up  the file's z axis points up, else y.
AffineMap upright_frame(bool z_up, bool left_handed);

/// Creates a scene of models, lit by the lights of their files and by a clear sky with the sun at 40 degrees.
/// The exposure is found automatically. POV-Ray scenes are lit by their own lights alone and get no sky.
/// Lights in photometric units are scaled, with a warning, if a white sphere (albedo 0.8) amid the models
/// would exceed radiance 1. They are also scaled if the models are in a closed room.
///
/// Left-handed coordinates of POV-Ray files (ModelFile::is_left_handed) become right-handed: the instances
/// and lights of such a file are mirrored, so that a picture shows the models as POV-Ray does.
///
/// Models of several files whose boxes overlap are placed side by side along x, on one level, with a warning.
///
/// The floor has three entities. `floor` is a square that extends 0.8 times the models' longest side in each
/// direction, with vertices dense enough for shadows below the models. `apron` surrounds it to twice the
/// longest side, and `ground` surrounds both to the horizon. Their albedo makes them as bright as the
/// environment below the horizon.
///
/// If one room encloses all models, and no file has a camera, the camera is placed inside the room. A room
/// with windows and doors is recognized if its triangles face inwards and surround a place on most sides,
/// with level floor and vertical walls. If nothing emits light in a room without openings, a lamp is added
/// below the ceiling, with a warning.
///
/// A part of a file (ModelParts) becomes an entity, and each node of the part an instance. A file whose parts
/// are untransformed and each used once, as in OBJ and PLY, becomes one entity. All have the materials of
/// their files. The camera is the first that a file has; without one, Scene::finds_camera is set.
///
/// An entity with rooms (closed_pieces.h) faces inwards. Objects, lights and cameras of all files count as
/// contents of a room.
///
/// folder  the directory of the scene file, which will hold `floor.obj`.
/// errors  as ModelFile::open and read_mesh; a transform that placed_shape refuses; no surface in any file.
/// cost    reads each file once.
Result<ImportedScene> scene_of_models(std::span<const std::filesystem::path> files,
                                      const std::filesystem::path& folder, const SceneImport& wanted,
                                      const Progress& progress = {});

/// Returns a light of a file as a lamp of the scene, without a name. Units of the colour are POV-Ray's.
///
/// world  from the file's coordinates to the scene's; multiplies lengths by `scale`.
SceneLamp scene_lamp(const ModelLight& light, const AffineMap& world, double scale);

}  // namespace haarfield
