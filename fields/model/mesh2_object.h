#pragma once
/// One mesh2 object, and what stands in the braces of objects, taken off a POV-Ray text.

#include "fields/model/mesh2_file.h"
#include "fields/model/povray_text.h"

namespace haarfield {

/// Takes what follows the keyword `mesh2`, to its last brace. Nothing of worth if the text has failed.
Mesh2 mesh2_object(PovrayText& text);

/// Takes what follows a keyword that moves things, and lets `transform` do that after what it does; false,
/// and nothing is taken, if `word` is none.
bool take_transformation(std::string_view word, PovrayText& text, AffineMap& transform);

/// Takes a block in braces. Returns NAME of `{ NAME }`, also if transformations follow it; else "".
std::string plain_name(PovrayText& text);

}  // namespace haarfield
