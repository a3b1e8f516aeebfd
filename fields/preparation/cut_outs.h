#pragma once
/// Surfaces that an image cuts holes into: leaves on cards, grids, lace.

#include "fields/mesh/mesh.h"
#include "fields/preparation/opaque_outline.h"

#include <span>

namespace haarfield {

/// Which triangles are cut into: 1 where a texel that is less than half opaque touches the box round a
/// triangle in its material's image, or nearly; else 0.
///
/// maps  by the mesh's materials, or none; if any has holes the mesh has uvs.
std::vector<std::uint8_t> cut_out_triangles(const Mesh& mesh, std::span<const OpacityMap> maps);

/// What of a mesh blocks light: triangles where their image is at least half opaque, and nothing elsewhere.
/// What is less opaque than that lets all light pass, and what is more so none.
///
/// maps             as above.
/// most_triangles   to put in the place of those that are cut into. There can be as many as 16 for each of
///                  these, if less would not show more than their images' rough shape.
/// returns          positions and triangles, of which the normals are their own; triangles that are not cut
///                  into come first, as they are. All of the mesh's positions are there, used or not.
/// accuracy         opaque_outline.h, with a tolerance of a quarter of a texel; doubled while there are too
///                  many triangles, up to a sixteenth of the image. If there are too many even then (a
///                  fine grid that repeats a thousand times), triangles are there wholly if their images are
///                  at least half opaque in the mean, or not at all.
/// cost             some microseconds per texel of the outlines and per triangle made, for each tolerance.
Mesh without_cut_outs(const Mesh& mesh, std::span<const OpacityMap> maps, std::size_t most_triangles);

}  // namespace haarfield
