#pragma once
/// Shading that several processes share: each shades some of the points, and one puts them together.

#include <functional>
#include <span>

#include "shading/scene/vertex_loop.h"

namespace haarfield {

/// A loop over points, of which a process may shade some, and have others from elsewhere.
struct SharedLoop {
    std::size_t points = 0;
    /// Shades the points from number `begin` up to, but not at, `end`: their radiance.
    std::function<Result<std::vector<Rgb>>(std::size_t begin, std::size_t end)> shaded;
    /// Takes the radiance of points from number `begin` on.
    std::function<void(std::size_t begin, std::span<const Rgb> radiance)> take;
};

/// Decides what of a loop is shaded, and what is taken. Points of which it does neither have no radiance.
using PointSharing = std::function<Result<Done>(const SharedLoop& loop)>;

/// While it lives, the loops over points with scene_radiance, point_radiance and dense_scene_radiance go
/// through a sharing, in the order in which they are made. It is the process's, as a process has one share:
/// there is one at a time (asserted).
class SharedShading {
public:
    /// has_all  whether every point has its radiance after a loop; else only those of the process's share
    ///          have.
    SharedShading(PointSharing sharing, bool has_all);
    SharedShading(const SharedShading&) = delete;
    SharedShading& operator=(const SharedShading&) = delete;
    ~SharedShading();
};

/// Ends it: the loops that follow are made as wholes, by a process that has all points of those before.
void end_sharing();

/// Whether only a share of the points has radiance, so that nothing that follows from all of it is of use.
bool has_share_alone();

/// A loop over points: by the sharing, if there is one; otherwise all are shaded.
///
/// shade  shades the points from number `begin` up to, but not at, `end`, and maybe some of their neighbours.
Result<Done> share_points(std::span<Rgb> radiance,
                          const std::function<Result<Done>(std::size_t begin, std::size_t end)>& shade);

/// Likewise over a scene's vertices.
///
/// orders    of each entity's vertices, as visit_vertices has them: they are numbered so, instance by
///           instance.
/// radiance  by instance and vertex. Instances without values get room for them, black, before they are
///           shaded; where there is a share alone, others stay without.
/// shade     shades those of the mask, by instance and vertex, and maybe some of their neighbours; all, if
///           it is null. Where nothing is wanted of an instance, the mask has no values.
Result<Done> share_vertices(const ShadedScene& scene, std::span<const std::span<const std::uint32_t>> orders,
                            SceneRadiance& radiance,
                            const std::function<Result<Done>(const VertexMask* wanted)>& shade);

/// visit_vertex_runs, of the runs of which a mask wants any vertex; of all, if it is null.
///
/// cost  that of instances of which something is wanted.
Result<Done> visit_wanted_runs(const ShadedScene& scene,
                               std::span<const std::span<const std::uint32_t>> orders,
                               const VertexMask* wanted,
                               const std::function<VertexRunVisitor()>& make_visitor, std::string_view stage,
                               const Progress& progress);

}  // namespace haarfield
