#pragma once
/// The rows of vertices that no light reaches.

#include "shading/visibility/vertex_rows.h"

namespace haarfield {

/// Marks the rows of buried vertices and of vertices inside other instances.
///
/// returns  by row: 1 if it is hidden.
/// cost     that of PlacedSolids::buried_vertices for all instances.
std::vector<std::uint8_t> hidden_rows(const ShadedScene& scene, const ShadingGeometry& geometry);

}  // namespace haarfield
