#pragma once
/// Surfaces with holes cut by an image: leaves on cards, grids, lace.

#include "fields/mesh/mesh.h"
#include "fields/preparation/opaque_outline.h"

#include <span>

namespace haarfield {

/// Returns 1 for triangles that an image may cut: in the material's image, a texel that is less than half
/// opaque touches the triangle's bounding box, or nearly does. Otherwise 0.
///
/// maps  one per material of the mesh, or none. If any has holes, the mesh must have uvs.
std::vector<std::uint8_t> cut_out_triangles(const Mesh& mesh, std::span<const OpacityMap> maps);

/// Returns the part of a mesh that blocks light: the triangles where their image is at least half opaque.
/// Areas that are less opaque transmit all light, all others none.
///
/// maps             as above.
/// most_triangles   the number of triangles that may replace the cut ones. At the largest tolerance, at least
///                  16 per cut triangle are allowed, so that the rough shapes of the images are preserved.
/// returns          positions and triangles, with geometric normals. Uncut triangles come first and are
///                  unchanged. All positions of the mesh are kept, even if unused.
/// accuracy         that of opaque_outline.h, with a tolerance of a quarter of a texel, which is doubled
///                  while there are too many triangles, up to a sixteenth of the image. If there are still
///                  too many (a fine grid that repeats a thousand times), triangles are kept if the mean
///                  opacity of their images is at least one half, and removed otherwise.
/// cost             a few microseconds per texel of the outlines and per new triangle, for each tolerance.
Mesh without_cut_outs(const Mesh& mesh, std::span<const OpacityMap> maps, std::size_t most_triangles);

}  // namespace haarfield
