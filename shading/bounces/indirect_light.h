#pragma once
/// Light that comes from other surfaces: diffuse reflection, any number of times.
///
/// Every surface takes part with its diffuse term alone: what highlights send on to other surfaces is left
/// out, as POV-Ray's radiosity leaves it out, too. Seen are highlights of diffuse surroundings.

#include "shading/bounces/fine_surface.h"
#include "shading/bounces/light_transport.h"
#include "shading/walk/vertex_shading.h"

namespace haarfield {

/// What the bounces come to. By row.
struct BouncedLight {
    std::vector<Rgb> irradiance;  ///< Of all bounces, as the transport's rays have it. [W/m^2]
    std::vector<Rgb> radiance;    ///< Diffuse, direct and reflected. [W/(m^2 sr)]
    int bounces = 0;              ///< That were computed.
    double left_out = 0;  ///< What the others would add, relative to a row's radiance, as it is estimated.
};

/// Lets light go to and fro.
///
/// reflectance  diffuse albedo / pi, by row. [1/sr]
/// direct       diffuse radiance by direct light, by row. [W/(m^2 sr)]
/// settings     ends after `most` bounces, or where all others would add less than `tolerance` of a row's
///              radiance, in the mean over the rows, if each were to the last as that to the one before. In
///              that case they are added as multiples of the last.
/// errors       interrupted.
Result<BouncedLight> bounced_light(const LightTransport& transport, std::span<const Rgb> reflectance,
                                   std::span<const Rgb> direct, const BounceSettings& settings,
                                   const Progress& progress = {});

/// Diffuse albedo / pi of a scene's vertices, with their tints, by row. [1/sr]
std::vector<Rgb> row_reflectances(const ShadedScene& scene, const ShadingGeometry& geometry);

/// Indirect light at the points of a scene's surfaces.
struct IndirectLight {
    std::shared_ptr<const FineSurface> surface;
    SceneColours irradiance;  ///< By vertex, smoothed. [W/m^2]
    SceneColours radiance;    ///< By vertex: diffuse, direct and reflected, tinted. [W/(m^2 sr)]
    int bounces = 0;
    double left_out = 0;  ///< As BouncedLight has it.
    std::size_t transport_bytes = 0;

    /// Irradiance of a point that is no vertex: between those of the triangle below it. In the entity's
    /// frame.
    ///
    /// cost  some 0.2 us.
    Rgb irradiance_at(const ShadedScene& scene, std::size_t instance, const SurfacePoint& point) const;

    /// Computes the radiance of a point by indirect light. Specular lobes reflect diffuse radiance only.
    ///
    /// from      in the world, off the surface.
    /// arriving  the irradiance of the point. [W/m^2]
    /// accuracy  24 rays per lobe, distributed by its density, the same for all points.
    /// cost      some 5 us per lobe.
    Outgoing outgoing(const ShadedScene& scene, const Vec3f& from, const VertexBrdf& brdf,
                      const Rgb& arriving) const;
};

/// Puts together what bounced.
///
/// cost  that of smoothing.
IndirectLight indirect_light(const ShadedScene& scene, const ShadingGeometry& geometry,
                             std::shared_ptr<const FineSurface> surface, const LightTransport& transport,
                             BouncedLight bounced);

}  // namespace haarfield
