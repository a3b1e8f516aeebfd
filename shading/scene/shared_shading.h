#pragma once
/// Loops over points, divided among processes: each process shades some of the points, and one joins them.

#include <functional>
#include <span>

#include "shading/scene/vertex_loop.h"

namespace haarfield {

/// A loop over points. A process may shade some of the points and read the others from results of other
/// processes.
struct SharedLoop {
    std::size_t points = 0;
    /// Returns the radiance of the points with numbers in [begin, end).
    std::function<Result<std::vector<Outgoing>>(std::size_t begin, std::size_t end)> shaded;
    /// Stores the radiance of consecutive points, the first of which has the number `begin`.
    std::function<void(std::size_t begin, std::span<const Outgoing> radiance)> take;
};

/// The division of a job's loops over points among processes.
struct PointSharing {
    /// Shades or stores points of a loop. Points for which it does neither have no radiance. The loops of a
    /// job call it in the same order in each process.
    std::function<Result<Done>(const SharedLoop& loop)> run;
    /// True if every point has its radiance after a loop; false if only this process's points have.
    bool has_all = true;
};

/// True if only some points have their radiance, so that nothing can be computed from all of them.
inline bool is_partial(const PointSharing* sharing) {
    return sharing && !sharing->has_all;
}

/// Runs a loop over points.
///
/// sharing  null: all points are shaded.
/// shade    shades the points with numbers in [begin, end), and possibly some of their neighbours.
Result<Done> share_points(const PointSharing* sharing, std::span<Outgoing> radiance,
                          const std::function<Result<Done>(std::size_t begin, std::size_t end)>& shade);

/// Runs a loop over the vertices of a scene.
///
/// sharing   null: all vertices are shaded.
/// orders    of each entity's vertices, as for visit_vertices. Vertices are numbered in this order, instance
///           by instance.
/// radiance  by instance and vertex. An instance gets its vector, black, before its first vertex is shaded
///           or stored. If the sharing is partial, the vectors of other instances remain empty.
/// shade     shades the vertices of the mask, by instance and vertex, and possibly some of their neighbours;
///           all vertices if the mask is null. The mask of an instance without such vertices is empty.
Result<Done> share_vertices(const PointSharing* sharing, const ShadedScene& scene,
                            std::span<const std::span<const std::uint32_t>> orders, SceneRadiance& radiance,
                            const std::function<Result<Done>(const VertexMask* wanted)>& shade);

/// Visits the runs of visit_vertex_runs that contain a vertex of a mask; all runs if the mask is null.
///
/// cost  that of the instances with such vertices.
Result<Done> visit_wanted_runs(const ShadedScene& scene,
                               std::span<const std::span<const std::uint32_t>> orders,
                               const VertexMask* wanted,
                               const std::function<VertexRunVisitor()>& make_visitor, std::string_view stage,
                               const Progress& progress);

}  // namespace haarfield
