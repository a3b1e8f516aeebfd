#pragma once
/// Meshes of unusual numbers.

#include "tests/fuzz/fuzz_inputs.h"

namespace haarfield {

/// Returns an OBJ file of a few points and random triangles. Coordinates are random bits of floats up to 1e6,
/// or 0, 0.5 and 1.
std::string odd_mesh(FuzzRandom& random);

}  // namespace haarfield
