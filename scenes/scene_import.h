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
    bool floor = false;  ///< Puts a grey square below them, four times as wide as they are.
    /// Vertices to be baked, of all instances together, shared out by the area of their surfaces.
    std::uint32_t vertices = 150000;
};

/// A scene, and the floor's mesh if one is wanted.
struct ImportedScene {
    Scene scene;
    std::string floor_obj;  ///< The text of the file that the entity `floor` names.
    std::vector<std::string> warnings;
};

/// Makes a scene of models, lit by the lights of their files; without any, under a clear sky with the sun at
/// 40 degrees, with the exposure found.
///
/// A part of a file (ModelParts) becomes an entity, of which each of the file's nodes is an instance. A file
/// whose parts stand where they are and none twice, as in OBJ and PLY, becomes one entity. All have the
/// files' own materials. The camera is the first that a file has, or is to be found (Scene::finds_camera).
///
/// folder  where the scene will be; there lies `floor.obj`.
/// errors  as ModelFile::open and read_mesh; a place that linear_parts refuses; nothing with a surface.
/// cost    reads each file once.
Result<ImportedScene> scene_of_models(std::span<const std::filesystem::path> files,
                                      const std::filesystem::path& folder, const SceneImport& wanted,
                                      const Progress& progress = {});

}  // namespace haarfield
