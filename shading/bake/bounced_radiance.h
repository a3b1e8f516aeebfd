#pragma once
/// Radiance with the light that bounces: direct light at the vertices, what it comes to, and both together.

#include "shading/bake/renderer.h"

namespace haarfield {

/// What of bounces depends on where things stand, and not on light.
struct BounceRays {
    std::shared_ptr<const FineSurface> surface;
    LightTransport transport;  ///< Not refined.
};

/// before  null, or rays of the same entities, wherever their instances stood: what depends on entities
///         alone is shared.
/// cost    settings.bounces.directions rays a vertex, of some 0.2 us.
/// errors  interrupted.
Result<BounceRays> bounce_rays(const ShadedScene& scene, const ShadingGeometry& geometry,
                               const RenderSettings& settings, const Progress& progress = {},
                               const BounceRays* before = nullptr);

/// Diffuse radiance by row as surfaces send it: with their tints.
std::vector<Rgb> tinted_rows(const ShadedScene& scene, const VertexRows& rows, std::vector<Rgb> diffuse);

/// The indirect light of a scene.
///
/// direct   a shading by direct light alone, with the bounces in its settings.
/// diffuse  what it makes of the vertices: RadianceParts::diffuse.
/// rays     of the scene as it stands.
/// cost     up to as many rays more, and a pass over what they met for each bounce.
/// errors   interrupted.
Result<IndirectLight> scene_indirect_light(const PointShading& direct, const SceneRadiance& diffuse,
                                           const BounceRays& rays, const Progress& progress = {});
Result<IndirectLight> scene_indirect_light(const PointShading& direct, const SceneRadiance& diffuse,
                                           const Progress& progress = {});  ///< With rays of its own.

/// The same where the diffuse radiance is not at hand.
Result<IndirectLight> scene_indirect_light(const PointShading& direct, const Progress& progress = {});

/// scene_radiance with indirect light, if the settings ask for bounces.
///
/// direct    as above.
/// indirect  is set to the scene's indirect light; empty if there are no bounces or the sharing is partial.
///           Processes share the direct light only.
Result<SceneRadiance> bounced_radiance(const PointShading& direct, std::optional<IndirectLight>& indirect,
                                       const Progress& progress = {});

/// What indirect light alone makes of points, which are as for point_radiance. The shading has it.
///
/// cost    that of highlights, where there are any.
/// errors  interrupted.
Result<std::vector<Rgb>> indirect_radiance(const PointShading& shading, std::span<const InstancePoint> points,
                                           const Progress& progress = {});

/// The same of vertices; added to their radiance.
Result<Done> add_indirect_radiance(const PointShading& shading, SceneRadiance& radiance,
                                   const Progress& progress = {});

}  // namespace haarfield
