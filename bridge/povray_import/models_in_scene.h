#pragma once
/// Scenes of models that stand in an existing POV-Ray scene and are lit by it.

#include "bridge/povray_import/scene_queries.h"
#include "scenes/scene_import.h"

namespace haarfield {

/// A place for models in a POV-Ray scene.
struct PlaceInScene {
    QueryOptions queries{};
    std::filesystem::path file;  ///< The POV-Ray scene.
    Vec3d at{0, 0, 0};           ///< The middle of the bottom of the models' box, in the file's coordinates.
    std::optional<bool> z_up{};  ///< The file's z axis points up; none: found from the camera.
    int width = 512;             ///< Of the image of the light, even. [pixels]
    SceneImport models{};        ///< How the models are imported; place and environment are replaced.
};

/// Models in a POV-Ray scene.
struct ModelsInScene {
    Scene scene;
    std::vector<std::string> warnings;
    /// Where the light was rendered: the centre of the models' box, in the file's coordinates.
    Vec3d probe{0, 0, 0};
    std::size_t lights = 0;  ///< Number of the file's lights that are lights of the scene.
    /// The error of treating the light as distant: RMS difference between the irradiance at points near the
    /// corners of the models' box and at its centre, over all normals, relative to the RMS at the centre.
    double corner_difference = 0;
    double largest_corner_difference = 0;  ///< At the corner that differs most.
};

/// Creates a scene of models that stand in a POV-Ray scene. The light at the centre of their box is the
/// environment, and the file's camera is the camera. Lengths are in the file's units, and radiance in its
/// numbers, which are not linear if the file has an `assumed_gamma` other than 1.
///
/// Light is probed at eight more points, each nine tenths of the way from the centre to a corner of the box.
///
/// files   models, as for scene_of_models.
/// writes  the environment, an OpenEXR image.
/// errors  those of scene_of_models and SceneQueries; no light at the centre of the box; a file that cannot
///         be written.
/// cost    thirteen runs of POV-Ray.
Result<ModelsInScene> models_in_scene(std::span<const std::filesystem::path> files, const PlaceInScene& place,
                                      const std::filesystem::path& environment,
                                      const Progress& progress = {});

}  // namespace haarfield
