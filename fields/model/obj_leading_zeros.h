#pragma once
/// A workaround for OBJ numbers that assimp does not read.

#include <string>

namespace haarfield {

/// Returns the text of an OBJ file with a zero before every leading decimal point of a number (`.5`, `-.5`)
/// in lines of vertices, texture coordinates or normals. assimp 5.2 does not read such numbers.
std::string with_leading_zeros(const std::string& text);

}  // namespace haarfield
