#pragma once
/// The supported model formats, and their detection by content, not by file name.

#include <optional>
#include <string_view>

namespace haarfield {

/// A supported format. Only the readers of these formats are given files.
enum class ModelFormat { obj, ply, gltf, glb, stl, off, mesh2 };

/// For messages and help.
inline constexpr std::string_view model_formats = "OBJ, PLY, glTF (.gltf, .glb), STL, OFF or POV-Ray's mesh2";

/// Detects the format of a file: by its first bytes, or for formats without a signature (STL, OBJ, mesh2), by
/// its content. Returns nothing for any other file.
///
/// ending  the extension of the file's name, in lower case with the dot. It decides between OBJ and POV-Ray
///         if both are possible: the word `mesh2` may occur in a comment of an OBJ file, and `v 1 2 3` in a
///         POV-Ray file.
std::optional<ModelFormat> model_format(std::string_view bytes, std::string_view ending);

}  // namespace haarfield
