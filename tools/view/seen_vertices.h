#pragma once
/// Which vertices a camera may see, without tracing rays.

#include "shading/scene/vertex_loop.h"
#include "tools/view/design.h"

namespace haarfield {

/// The vertices that are in the camera's picture, or a tenth of its size beside it, and whose surface is
/// turned towards it, or nearly: of triangles with such a vertex, all.
///
/// ids   by place in the result: which objects.
/// cost  some 2 ms for 200,000 vertices.
VertexMask seen_vertices(const Design& design, const Camera& camera, const SceneEntities& entities,
                         std::span<const std::uint32_t> ids);

}  // namespace haarfield
