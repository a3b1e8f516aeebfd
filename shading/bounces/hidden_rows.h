#pragma once
/// The rows of vertices that no light reaches.

#include "shading/bounces/fine_surface.h"
#include "shading/visibility/vertex_rows.h"

namespace haarfield {

/// Marks the rows of buried vertices and of vertices inside other instances.
///
/// returns  by row: 1 if it is hidden.
/// cost     that of PlacedSolids::buried_vertices for all instances.
std::vector<std::uint8_t> hidden_rows(const ShadedScene& scene, const ShadingGeometry& geometry);

/// Returns the barycentric weights of the corners of a triangle that are not hidden, and zero for the others.
///
/// corners  the rows of the corners.
/// hidden   that of hidden_rows.
std::array<float, 3> open_weights(const SurfaceHit& hit, const std::array<std::uint32_t, 3>& corners,
                                  std::span<const std::uint8_t> hidden);

}  // namespace haarfield
