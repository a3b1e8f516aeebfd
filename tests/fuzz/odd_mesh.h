#pragma once
/// Meshes of odd numbers.

#include "tests/fuzz/fuzz_inputs.h"

namespace haarfield {

/// An OBJ file of some points, whose coordinates are any floats up to 1e6 by their bits, or 0, 0.5 and 1, and
/// of any triangles between them.
std::string odd_mesh(FuzzRandom& random);

}  // namespace haarfield
