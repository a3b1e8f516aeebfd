#pragma once
/// Radiance at the vertices of a scene: one product integral per vertex.

#include "fields/base/progress.h"
#include "fields/base/result.h"
#include "shading/bounces/indirect_light.h"
#include "shading/scene/scene_light.h"
#include "shading/scene/shared_shading.h"
#include "shading/visibility/kept_visibility.h"
#include "shading/walk/vertex_shading.h"

namespace haarfield {

/// A material, seen from the eye; material.h has both conventions.
VertexBrdf vertex_brdf(const Material& material, const VertexView& view);

/// Outgoing radiance towards the eye, by instance and vertex of its fine mesh. [W/(m^2 sr)]
///
/// Vertices that face away from the eye get the radiance that they would show at grazing view: the
/// highlight's mirror direction is taken with the view vector's component into the surface removed.
/// Buried vertices (LocalSamples::buried) take the mean of their nearest unburied neighbours.
///
/// cost    some 10 us a vertex if others are seen by their fields, and 40 us if near ones are rasterized; on
///         all of oneTBB's threads, and the result does not depend on their number.
/// errors  interrupted.
Result<SceneRadiance> scene_radiance(const ShadedScene& scene, const RenderSettings& settings,
                                     const Progress& progress = {});

/// The inputs of a shading, all of which must outlive it.
struct PointShading {
    const ShadedScene& scene;
    const ShadingGeometry& geometry;
    const SceneLight& light;
    const RenderSettings& settings;
    const KeptVisibility* visibility = nullptr;  ///< Cached visibility of the vertices; null: it is sampled.
    const IndirectLight* indirect = nullptr;     ///< Null: direct light only.
    const PointSharing* sharing = nullptr;       ///< Null: this process shades all points.
};

/// The same for new light or a new eye, with what does not depend on them made once: with the same bits,
/// whether the visibility was kept or not.
Result<SceneRadiance> scene_radiance(const PointShading& shading, const Progress& progress = {});

/// Radiance, and what of it is diffuse.
struct RadianceParts {
    SceneRadiance full, diffuse;
};

/// The same with the diffuse part apart, as materials have it, without tints.
///
/// cost  a second walk for vertices that have highlights.
Result<RadianceParts> radiance_parts(const PointShading& shading, const Progress& progress = {});

/// A point of an instance's surface.
struct InstancePoint {
    std::size_t instance = 0;
    SurfacePoint point;
};

/// Outgoing radiance of points that need not be vertices: as that of vertices, with the points' own
/// visibility rasterized. In the points' order, in which neighbours should be near each other.
///
/// cost  some 50 us a point.
Result<std::vector<Rgb>> point_radiance(const PointShading& shading, std::span<const InstancePoint> points,
                                        const Progress& progress = {});

}  // namespace haarfield
