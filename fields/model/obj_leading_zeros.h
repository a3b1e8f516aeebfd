#pragma once
/// OBJ files as assimp wants to see them.

#include <string>

namespace haarfield {

/// The text of an OBJ file with a zero before every decimal point that begins a number (`.5`, `-.5`) in a
/// line of vertices, texture coordinates or normals: assimp 5.2 takes it for no number at all.
std::string with_leading_zeros(const std::string& text);

}  // namespace haarfield
