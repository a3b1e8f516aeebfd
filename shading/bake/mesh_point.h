#pragma once
/// Points of a scene's surfaces that are no vertices.

#include "shading/scene/vertex_loop.h"

#include <optional>

namespace haarfield {

/// A point of an instance's fine mesh: the corners of the triangle weigh 1 - u - v, u and v.
struct MeshPoint {
    std::uint32_t instance = 0, triangle = 0;
    float u = 0, v = 0;

    std::array<float, 3> weights() const { return {1 - u - v, u, v}; }  ///< Of the triangle's corners.
};

/// The point with its normal, interpolated, and the place that it looks from, right above it. Nothing if the
/// triangle is buried in another piece of the entity, or one of its corners is.
std::optional<SurfacePoint> surface_point(const ShadedEntity& entity, const MeshPoint& point);

}  // namespace haarfield
