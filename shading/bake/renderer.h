#pragma once
/// Radiance at the vertices of a scene: one product integral per vertex.

#include "fields/base/progress.h"
#include "fields/base/result.h"
#include "shading/bounces/indirect_light.h"
#include "shading/scene/scene_light.h"
#include "shading/scene/shared_shading.h"
#include "shading/visibility/cached_visibility.h"
#include "shading/walk/vertex_shading.h"

namespace haarfield {

/// Computes the outgoing radiance towards the eye, by instance and vertex of its fine mesh. [W/(m^2 sr)]
///
/// Tints of entities are not applied. Vertices that face away from the eye get their radiance at grazing
/// view: the view direction is projected to the tangent plane before it is mirrored (mirrored_view). Buried
/// vertices (LocalSamples::buried) get the mean of their nearest unburied neighbours.
///
/// cost    about 10 us per vertex if occlusion by other instances comes from fields, 40 us if near occluders
///         are rasterized; on all of oneTBB's threads. The result does not depend on their number.
/// errors  interrupted.
Result<SceneRadiance> scene_radiance(const ShadedScene& scene, const RenderSettings& settings,
                                     const Progress& progress = {});

/// A scene to shade with the data that shading needs, all of which must outlive the shading.
struct PointShading {
    const ShadedScene& scene;
    const ShadingGeometry& geometry;
    const SceneLight& light;
    const RenderSettings& settings;
    const CachedVisibility* visibility =
        nullptr;                              ///< Cached visibility of the vertices; null: it is sampled.
    const IndirectLight* indirect = nullptr;  ///< Null: direct light only.
    const PointSharing* sharing = nullptr;    ///< Null: this process shades all points.
};

/// Computes the radiance for new light or a new eye, from data that do not depend on them. The result is
/// bit-identical with and without stored visibility.
Result<SceneRadiance> scene_radiance(const PointShading& shading, const Progress& progress = {});

/// A point of an instance's surface.
struct InstancePoint {
    std::size_t instance = 0;
    SurfacePoint point;
    std::optional<Rgb> irradiance{};  ///< Its indirect irradiance; none: to be gathered. [W/m^2]
};

/// Computes the outgoing radiance of points that need not be vertices, in their order. Occlusion of a point
/// by its own entity is rasterized. Points that are next to each other in the order should be close in space.
///
/// cost  some 50 us per point.
Result<std::vector<Outgoing>> point_radiance(const PointShading& shading,
                                             std::span<const InstancePoint> points,
                                             const Progress& progress = {});

}  // namespace haarfield
