#pragma once
/// MTL files, the materials of OBJ files.

#include <string>

namespace haarfield {

/// Replaces the statements before the first `newmtl` by blanks. They belong to no material, and assimp 5.2
/// crashes on some of them.
std::string without_leading_statements(std::string mtl);

}  // namespace haarfield
