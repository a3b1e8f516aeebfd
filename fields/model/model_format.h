#pragma once
/// Which models are read, and how they are known: by what is in the file, whatever it is called.

#include <optional>
#include <string_view>

namespace haarfield {

/// A format that is read. The readers of these, and no others, are given files.
enum class ModelFormat { obj, ply, gltf, glb, stl, off, mesh2 };

/// For messages and help: `OBJ, PLY, glTF, ...`.
inline constexpr std::string_view model_formats = "OBJ, PLY, glTF (.gltf, .glb), STL, OFF or POV-Ray's mesh2";

/// What a file begins with or, of the formats without a beginning of their own (STL, OBJ, mesh2), what is in
/// it; none if that is none of them.
///
/// ending  of the file's name, lower case, with its point: the word `mesh2` may stand in a comment of an OBJ
///         file, and `v 1 2 3` in one of POV-Ray's, so that it decides between these two where both may be.
std::optional<ModelFormat> model_format(std::string_view bytes, std::string_view ending);

}  // namespace haarfield
