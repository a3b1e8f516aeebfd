#pragma once
/// Writes the files that place a whole bake in an existing POV-Ray scene.

#include "bridge/povray/baked_scene.h"

namespace haarfield {

/// Returns `matrix <...>` from a scene's coordinates to those of its surroundings.
std::string matrix_into(const Surroundings& surroundings);

/// The files of a placed bake.
struct PlacedBake {
    std::filesystem::path include;  ///< `NAME_Baked.inc`
    std::string object;             ///< The object that it declares: `Name_Baked`.
    /// `NAME_in_place.pov`: the surroundings with the object; empty without surroundings.
    std::filesystem::path scene;
};

/// Writes `NAME_Baked.inc`, which declares one object for all instances of a bake, and, if the scene has
/// surroundings, `NAME_in_place.pov`, which includes them and places that object.
///
/// The object has the coordinates of the surroundings; without surroundings, those of the baked scene.
/// `NAME_in_place.pov` includes the surroundings by the name of their file, which POV-Ray must find by its
/// option +L; by the whole path if a file of that name is in `folder`.
///
/// scene_name  as for write_baked_scene.
/// files       the result of write_baked_scene in the same folder.
/// errors      quotation marks in the name of the surroundings' file; I/O errors.
Result<PlacedBake> write_placed_bake(const std::filesystem::path& folder, const std::string& scene_name,
                                     const BakedFiles& files, const Camera& camera,
                                     const std::optional<Surroundings>& surroundings);

}  // namespace haarfield
