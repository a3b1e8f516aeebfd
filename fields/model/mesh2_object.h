#pragma once
/// Parsers of a mesh2 object, and of items in the braces of objects, in a POV-Ray text.

#include "fields/model/mesh2_file.h"
#include "fields/model/povray_text.h"

namespace haarfield {

/// Reads a mesh2 from after its keyword to its closing brace. The result is meaningless if the text has
/// failed.
Mesh2 mesh2_object(PovrayText& text);

/// Reads the arguments of a transformation whose keyword is `word`, and appends it to `transform`. Returns
/// false and reads nothing if `word` is not such a keyword.
bool take_transformation(std::string_view word, PovrayText& text, AffineMap& transform);

/// Reads a block in braces. Returns NAME for `{ NAME }`, also if transformations follow the name; otherwise
/// "".
std::string plain_name(PovrayText& text);

}  // namespace haarfield
