#pragma once
/// Meshes that are refined where their radiance requires it.

#include "shading/bake/radiant_mesh.h"

namespace haarfield {

/// The vertex budget over the number of start vertices: most vertices are left for regions of varying
/// radiance, and nothing of the size of shadows is missed.
inline constexpr std::size_t refinement_share = 6;

/// The limits of a refinement.
struct RefinementSettings {
    /// Largest difference between the radiance at the middle of an edge and its interpolation, relative to
    /// the radiance plus the scene's mean radiance; each is summed over the channels. The tolerance is
    /// therefore relative in bright and absolute in dark regions, for any exposure.
    float tolerance = 0.01f;
    std::size_t vertex_budget = 60000;  ///< Over all instances.
};

/// Refined meshes, and statistics of the refinement.
struct Refinement {
    std::vector<RadiantMesh> meshes;  ///< By instance.
    float largest_error = 0;          ///< Of the edges that were evaluated and not split, as `tolerance`.
    std::size_t shaded_points = 0;    ///< Vertices, and middles of edges that were not split.
    int rounds = 0;
};

/// Splits edges with a large interpolation error until the tolerance is met or the budget is used up.
///
/// Each round shades the middles of all edges that are the longest of a triangle, or whose ends differ by
/// more than the tolerance. It then splits edges beyond the tolerance in descending order of error times
/// length, down to half of the largest. A triangle is always divided across its longest edge first, so that
/// angles stay above half of the smallest angle in `start`. There are no T-junctions. Edges below a
/// thousandth of the entity's radius are not split.
///
/// start     by instance, from mesh_radiance. Unchanged if it has more vertices than the budget.
/// accuracy  bit-identical for any number of threads.
/// cost      about 50 us per shaded point; two to three times as many points as vertices.
/// errors    interrupted.
/// source    the four-triangle longest-edge partition: Rivara 1984, Algorithms for refining triangular grids
///           suitable for adaptive and multigrid techniques.
Result<Refinement> refined_radiance(const PointShading& shading, const RefinementSettings& refinement,
                                    std::vector<RadiantMesh> start, const Progress& progress = {});

}  // namespace haarfield
