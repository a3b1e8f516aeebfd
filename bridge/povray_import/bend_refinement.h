#pragma once
/// More vertices where surfaces bend within few cells of their grid.

#include "bridge/povray_import/object_surfaces.h"

namespace haarfield {

/// Moves and adds vertices where surfaces bend strongly.
///
/// Vertices between normals that differ by more than 10 degrees are moved onto the surface. An edge that
/// dual_contour took for sharp becomes round if the surface faces its bisector there. Edges between such
/// normals are divided, down to an eighth of a cell, but not those along sharp edges. A surface gets at most
/// twice as many new vertices as it has, and at most 20,000. Surfaces of objects that are cut remain as they
/// are.
///
/// requests  sorted by object.
/// surfaces  without colours.
/// seconds   limit of each run of POV-Ray. [s]
/// errors    those of SceneQueries::answer. The surfaces are valid then, and some are refined.
/// cost      up to four runs of POV-Ray, and 40 us for each vertex that is moved or added.
Result<Done> refine_bends(const SceneQueries& queries, std::span<const GridRequest> requests,
                          std::vector<ObjectSurface>& surfaces, double seconds,
                          const Progress& progress = {});

}  // namespace haarfield
