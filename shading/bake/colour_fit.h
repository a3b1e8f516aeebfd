#pragma once
/// Vertex colours that minimise the error of interpolated radiance.

#include "shading/bake/radiant_mesh.h"

namespace haarfield {

/// Replaces the radiance of the vertices by the values whose linear interpolation over the triangles has the
/// least squared error, against samples in the middles of the triangles and at the vertices. The mean of the
/// error nearly vanishes, whereas interpolated samples are too bright across a dark crease. Both components
/// are fitted. Negative values are removed (without_negative).
///
/// meshes    by instance, from mesh_radiance or refined_radiance. Buried vertices, which no sample covers,
///           keep their radiance.
/// accuracy  the result does not depend on the number of threads.
/// cost      one shaded point per triangle, 50 us, and some 10 us per vertex.
/// errors    interrupted.
/// source    Kavan, Bargteil and Sloan 2011, Least squares vertex baking; the integral over a triangle is
///           taken by the rule of degree 2 with weights 3/4 in the middle and 1/12 at the corners, which
///           needs no further regularisation.
Result<Done> fit_radiance(const PointShading& shading, std::span<RadiantMesh> meshes,
                          const Progress& progress = {});

/// Returns the radiance of a mesh's vertices that is nearest to samples at the vertices and in the middles of
/// the edges, as fit_radiance.
///
/// sampled  by vertex.
/// middles  by triangle; the k-th is on the edge from corner k to the next.
/// cost     some 10 us per vertex.
std::vector<Outgoing> fitted_radiance(const Mesh& mesh, std::span<const Outgoing> sampled,
                                      std::span<const std::array<Outgoing, 3>> middles);

}  // namespace haarfield
