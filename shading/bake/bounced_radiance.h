#pragma once
/// Radiance with indirect light: direct light at the vertices, the indirect light that results, and their
/// sum.

#include "shading/bake/renderer.h"

namespace haarfield {

/// The data for indirect light that depends on placements but not on light.
struct BounceRays {
    std::shared_ptr<const FineSurface> surface;
    LightTransport transport;  ///< Not refined.
};

/// Traces the rays of indirect light.
///
/// before  null, or the rays of the same entities in other placements: data that depends on entities alone is
///         shared.
/// cost    settings.bounces.directions rays per vertex, of about 0.2 us.
/// errors  interrupted.
Result<BounceRays> bounce_rays(const ShadedScene& scene, const ShadingGeometry& geometry,
                               const RenderSettings& settings, const Progress& progress = {},
                               const BounceRays* before = nullptr);

/// Multiplies the diffuse radiance of each row by the tint of its surface.
std::vector<Rgb> tinted_rows(const ShadedScene& scene, const VertexRows& rows, std::vector<Rgb> diffuse);

/// Computes the indirect light of a scene.
///
/// direct    a shading by direct light alone, with the bounces in its settings.
/// radiance  of that shading; its diffuse component is used.
/// rays      of the scene with its instances in place.
/// cost      at most the cost of bounce_rays again, and a pass over all hits for each bounce.
/// errors    interrupted.
Result<IndirectLight> scene_indirect_light(const PointShading& direct, const SceneRadiance& radiance,
                                           const BounceRays& rays, const Progress& progress = {});
/// Computes the indirect light with new rays.
Result<IndirectLight> scene_indirect_light(const PointShading& direct, const SceneRadiance& radiance,
                                           const Progress& progress = {});

/// Computes the indirect light for gathering in scenes with bright patches (IndirectLight::lit). Evaluates
/// direct light inside the triangles that shadow edges cross, and chooses bright points.
///
/// direct, radiance, rays  as for scene_indirect_light.
/// cost                    that of scene_indirect_light, and up to 45,000 points of 20 to 50 us.
/// errors                  interrupted.
Result<IndirectLight> focused_indirect_light(const PointShading& direct, const SceneRadiance& radiance,
                                             const BounceRays& rays, const Progress& progress = {});

/// Computes the direct radiance first, then the indirect light.
Result<IndirectLight> scene_indirect_light(const PointShading& direct, const Progress& progress = {});

/// Computes scene_radiance, with indirect light if the settings have bounces. Vertices inside other instances
/// get the mean of their neighbours (PlacedFill); a partial sharing leaves them black.
///
/// direct    as above.
/// indirect  is set to the scene's indirect light; empty if there are no bounces or the sharing is partial.
///           Processes share the direct light only.
Result<SceneRadiance> bounced_radiance(const PointShading& direct, std::optional<IndirectLight>& indirect,
                                       const Progress& progress = {});

/// Computes the radiance of points by indirect light alone. The points are as for point_radiance; the shading
/// has indirect light.
///
/// cost    that of specular lobes, where there are any.
/// errors  interrupted.
Result<std::vector<Outgoing>> indirect_radiance(const PointShading& shading,
                                                std::span<const InstancePoint> points,
                                                const Progress& progress = {});

/// Replaces the irradiance of vertices by that of IndirectLight::irradiance_at.
///
/// cost    that of irradiance_at for each wanted vertex.
/// errors  interrupted; the indirect light must then be discarded.
Result<Done> gather_irradiance(const PointShading& direct, const VertexMask& wanted, IndirectLight& indirect,
                               const Progress& progress = {});

/// Adds the indirect light of the shading to the radiance of vertices.
Result<Done> add_indirect_radiance(const PointShading& shading, SceneRadiance& radiance,
                                   const Progress& progress = {});

}  // namespace haarfield
