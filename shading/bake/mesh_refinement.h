#pragma once
/// Meshes that are fine where their radiance needs it.

#include "shading/bake/radiant_mesh.h"

namespace haarfield {

/// What part of the vertices a refinement should start with: so that most are left for where the radiance
/// changes, and nothing of the size of shadows is missed.
inline constexpr std::size_t refinement_share = 6;

/// When a refinement ends.
struct RefinementSettings {
    /// How far radiance, interpolated at the middle of an edge, may be from the radiance there: the
    /// difference, relative to the radiance plus the scene's mean radiance, each added over the channels. So
    /// it is relative where the scene is bright and absolute where it is dark, whatever the exposure.
    float tolerance = 0.01f;
    std::size_t vertex_budget = 60000;  ///< Of all instances together.
};

/// Refined meshes, and what it took.
struct Refinement {
    std::vector<RadiantMesh> meshes;  ///< By instance.
    float largest_error = 0;          ///< Of the edges that were looked at and not split, as `tolerance`.
    std::size_t shaded_points = 0;    ///< Vertices, and middles of edges that were not split.
    int rounds = 0;
};

/// Splits edges where interpolated radiance errs, until the tolerance holds or the budget is spent.
///
/// In each round the middles of those edges that are the longest of a triangle, or whose ends differ by more
/// than the tolerance, are shaded, all together. Then edges beyond the tolerance are split, those first where
/// the error times the edge's length is largest: down to half of the largest in one round. A triangle is
/// always divided across its longest edge first, so that angles stay above half of the smallest in `start`;
/// there are no T-junctions. No edge below a thousandth of the entity's radius is split.
///
/// start     by instance, from mesh_radiance. If it has more vertices than the budget it stays as it is.
/// accuracy  the same bits for any number of threads.
/// cost      some 50 us per shaded point, of which there are two to three times as many as vertices.
/// errors    interrupted.
/// source    the four-triangle longest-edge partition: Rivara 1984, Algorithms for refining triangular grids
///           suitable for adaptive and multigrid techniques.
Result<Refinement> refined_radiance(const PointShading& shading, const RefinementSettings& refinement,
                                    std::vector<RadiantMesh> start, const Progress& progress = {});

}  // namespace haarfield
