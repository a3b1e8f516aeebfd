#pragma once
/// Mesh files as assimp wants to see them.

#include <assimp/IOSystem.hpp>
#include <filesystem>
#include <memory>
#include <string>

namespace haarfield {

/// The file system, but for one OBJ file: numbers without a leading zero (`.5`, `-.5`), which assimp 5.2
/// takes for no numbers at all, come with one. Anything else is passed on as it is.
std::unique_ptr<Assimp::IOSystem> obj_with_leading_zeros(const std::filesystem::path& file);

/// The text of an OBJ file with a zero before every decimal point that begins a number in a line of vertices,
/// texture coordinates or normals.
std::string with_leading_zeros(const std::string& text);

}  // namespace haarfield
