#pragma once
/// Scenes of POV-Ray files: meshes, colours, finishes, lights, camera and environment.

#include "bridge/povray_import/object_surfaces.h"
#include "scenes/scene.h"

namespace haarfield {

/// Options of an import.
struct PovrayImport {
    QueryOptions queries{};
    int detail = 48;               ///< Cells of the grid along an object that fills the picture. 8 to 512.
    double object_seconds = 20;    ///< Limit of processor time for the surface of one object. [s]
    std::optional<bool> z_up{};    ///< The file's z axis points up; none: found from the camera.
    double unit = 1;               ///< Length of the file's unit. [m], > 0.
    std::optional<double> size{};  ///< If set, replaces `unit`: the longest side of the sampled objects. [m]
    bool with_environment = true;  ///< Renders what is far away, and the sky, as the environment.
    std::uint32_t vertices = 150000;  ///< To be baked, over all objects.
};

/// Returns a perspective camera of a file as the camera of a scene, with a picture that is 640 pixels wide.
///
/// world     from the file's coordinates to the scene's.
/// box       of the objects; the target is at the depth of its centre.
/// warnings  receives what the scene's camera does not have.
Camera imported_camera(const SurveyedCamera& surveyed, const AffineMap& world, const Bounds& box,
                       std::vector<std::string>& warnings);

/// A scene whose meshes and environment have been written.
struct ImportedPovrayScene {
    Scene scene;
    std::vector<std::string> warnings;  ///< What was left out, with file and line.
    std::size_t objects = 0;            ///< That the file creates.
    std::size_t surfaces = 0;           ///< Objects that have become meshes.
    std::size_t distant = 0;            ///< Objects that are part of the environment only.
    std::size_t transparent = 0;        ///< Objects that are not baked because they are transparent.
    std::vector<std::size_t>
        mesh_objects;  ///< Indices of the objects that have become meshes, in rising order.
    std::vector<std::size_t> distant_objects;  ///< Indices of objects that are only in the environment.
    std::vector<std::size_t> live_objects;     ///< Indices of the transparent objects, in rising order.
    std::size_t failed = 0;                    ///< Objects without a mesh: too slow, or without a surface.
};

/// Imports a scene that POV-Ray evaluates: macros, loops and all kinds of objects.
///
/// Objects become meshes with the finish as material. Pigments that vary become one image for all objects;
/// others become vertex colours. Objects that a loop creates in large numbers become one mesh per
/// statement. Infinite objects are cut at thirty times the distance of the finite ones as seen from the
/// camera; beyond, they are part of the environment. So are objects ten times as far away as all nearer
/// ones, background, sky_sphere and fog.
///
/// Transparent objects are not baked. They filter the light of lamps, and remain POV-Ray's objects in a scene
/// that becomes the surroundings, with the file's lights and sky.
///
/// Left-handed coordinates become right-handed, so that pictures are not mirrored. An upward z axis becomes
/// y.
///
/// name    names of files begin with it.
/// writes  `NAME_OBJECT.ply` for each entity and filter, `NAME_pigments.png`, `NAME_environment.exr` and the
///         folder `NAME_live` in `folder`.
/// errors  those of SceneQueries; no object has a surface; errors of the file system.
/// cost    about ten runs of POV-Ray, and the sampling of each object.
Result<ImportedPovrayScene> imported_povray_scene(const std::filesystem::path& file,
                                                  const std::filesystem::path& folder,
                                                  const std::string& name, const PovrayImport& options,
                                                  const Progress& progress = {});

}  // namespace haarfield
