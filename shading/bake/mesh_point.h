#pragma once
/// Points of a scene's surfaces that are not vertices.

#include "shading/scene/vertex_loop.h"

#include <optional>

namespace haarfield {

/// A point of an instance's fine mesh: the triangle's corners have the weights 1 - u - v, u and v.
struct MeshPoint {
    std::uint32_t instance = 0, triangle = 0;
    float u = 0, v = 0;

    std::array<float, 3> weights() const { return {1 - u - v, u, v}; }  ///< Of the triangle's corners.
};

/// Returns the point with its interpolated normal and its sample point above the surface. Nothing if the
/// triangle is buried in another piece of the entity, or one of its corners is.
std::optional<SurfacePoint> surface_point(const ShadedEntity& entity, const MeshPoint& point);

}  // namespace haarfield
