#pragma once
/// Radiance of all vertices by a method that shades them one at a time.

#include <functional>

#include "shading/scene/shared_shading.h"

namespace haarfield {

/// Returns the radiance of a vertex of an instance.
using VertexEvaluation = std::function<Outgoing(std::size_t instance, std::uint32_t vertex)>;

/// Evaluates the vertices that are not buried, and fills in the others (BuriedFill).
///
/// make     returns an evaluation for one thread.
/// sharing  null: this process evaluates all vertices.
/// errors   interrupted.
Result<SceneRadiance> evaluated_vertices(const ShadedScene& scene,
                                         const std::function<VertexEvaluation()>& make,
                                         const Progress& progress, const PointSharing* sharing);

}  // namespace haarfield
