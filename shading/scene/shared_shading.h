#pragma once
/// Shading that several processes share: each shades some of the points, and one puts them together.

#include <functional>
#include <span>

#include "shading/scene/vertex_loop.h"

namespace haarfield {

/// Shades the points from number `begin` up to, but not at, `end`, and maybe some of their neighbours.
using ShadeRange = std::function<Result<Done>(std::size_t begin, std::size_t end)>;

/// Decides what of a loop is shaded: calls `shade` for it, and may take the radiance of these points, or give
/// others theirs. Those of which it does neither stay as they are.
using PointSharing = std::function<Result<Done>(std::span<Rgb> radiance, const ShadeRange& shade)>;

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

/// Whether only a share of the points has radiance, so that nothing that follows from all of it is of use.
bool has_share_alone();

/// A loop over points: by the sharing, if there is one; otherwise all are shaded.
Result<Done> share_points(std::span<Rgb> radiance, const ShadeRange& shade);

/// Likewise over a scene's vertices.
///
/// orders    of each entity's vertices, as visit_vertices has them: they are numbered so, instance by
///           instance.
/// radiance  by instance and vertex.
/// shade     shades those of the mask, by instance and vertex, and maybe some of their neighbours; all, if
///           it is null.
Result<Done> share_vertices(const ShadedScene& scene, std::span<const std::span<const std::uint32_t>> orders,
                            SceneRadiance& radiance,
                            const std::function<Result<Done>(const VertexMask* wanted)>& shade);

}  // namespace haarfield
