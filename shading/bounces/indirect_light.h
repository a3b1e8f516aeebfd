#pragma once
/// Indirect light: any number of bounces between diffuse surfaces.
///
/// Surfaces reflect light onto other surfaces by their diffuse term only, as in POV-Ray's radiosity. Specular
/// lobes reflect the diffuse radiance of other surfaces to the eye.

#include "shading/bounces/fine_surface.h"
#include "shading/bounces/light_transport.h"
#include "shading/bounces/lit_surface.h"
#include "shading/walk/vertex_shading.h"

namespace haarfield {

/// The sum over all bounces, by row of the transport matrix.
struct BouncedLight {
    std::vector<Rgb> irradiance;  ///< Indirect irradiance, not smoothed. [W/m^2]
    std::vector<Rgb> radiance;    ///< Diffuse radiance by direct and indirect light. [W/(m^2 sr)]
    int bounces = 0;              ///< Number of computed bounces.
    double left_out = 0;          ///< Estimated mean of the further bounces, relative to a row's radiance.
};

/// Computes the bounces of diffuse light.
///
/// The contributions of further bounces are estimated as a geometric series, whose ratio is that of the last
/// two bounces. The computation ends after `settings.most` bounces, or when this estimate is below
/// `settings.tolerance` of a row's radiance, in the mean over the lit rows. In the latter case the remainder
/// of the series is added, as a multiple of the last bounce.
///
/// reflectance  diffuse albedo / pi, by row. [1/sr]
/// direct       diffuse radiance by direct light, by row. [W/(m^2 sr)]
/// errors       interrupted.
Result<BouncedLight> bounced_light(const LightTransport& transport, std::span<const Rgb> reflectance,
                                   std::span<const Rgb> direct, const BounceSettings& settings,
                                   const Progress& progress = {});

/// Computes most bounces between the groups of `coarse` only: all but the first and a last one, which gathers
/// the light of the others.
///
/// coarse    that of `transport`.
/// accuracy  the indirect irradiance is within 1 % of that of all rows, in the mean over the rows.
/// cost      two bounces at all rows, and a fraction of it for each further bounce.
Result<BouncedLight> bounced_light(const LightTransport& transport, const CoarseTransport& coarse,
                                   std::span<const Rgb> reflectance, std::span<const Rgb> direct,
                                   const BounceSettings& settings, const Progress& progress = {});

/// Returns diffuse albedo / pi of the vertices of a scene, including their tints, by row. [1/sr]
std::vector<Rgb> row_reflectances(const ShadedScene& scene, const ShadingGeometry& geometry);

/// The indirect irradiance of a point, and how fast it may vary.
struct GatheredIrradiance {
    Rgb irradiance{0.0f};  ///< [W/m^2]
    /// Mean of 1 / distance to the surfaces over the directions, with the density of the cosine; infinite if
    /// unknown. Irradiance varies little over distances that are short compared with 1 / nearness, as in
    /// irradiance caches (Ward, Rubinstein and Clear, A ray tracing solution for diffuse interreflection,
    /// 1988). [1/m]
    float nearness = std::numeric_limits<float>::infinity();
};

/// Indirect light at the vertices of a scene and at points between them.
struct IndirectLight {
    std::shared_ptr<const FineSurface> surface;
    /// Null: radiance is interpolated between vertices, and points gather it along directions alone.
    /// Otherwise they also gather from bright points of the surfaces, which takes twice the time.
    std::shared_ptr<const LitSurface> lit;
    SceneColours irradiance;  ///< Indirect irradiance by vertex, smoothed. [W/m^2]
    SceneColours radiance;    ///< Diffuse, direct and indirect, with tints, by vertex. [W/(m^2 sr)]
    /// GatheredIrradiance::nearness by instance and vertex; empty if no irradiance was gathered. [1/m]
    std::vector<std::vector<float>> nearness;
    int bounces = 0;                  ///< BouncedLight::bounces.
    double left_out = 0;              ///< BouncedLight::left_out.
    std::size_t transport_bytes = 0;  ///< Memory of the transport matrix. [bytes]
    /// Number of directions of gathered_at (gathering_directions) and, with `lit`, of bright points.
    int gathering_rays = 256;

    /// Gathers the irradiance of a point from the diffuse radiance of the surfaces around it. Next to other
    /// surfaces it is more accurate than interpolation between vertices, which are too far apart there.
    ///
    /// point     in the frame of the entity.
    /// With `lit`, the balance heuristic weights directions and bright points (Veach and Guibas, Optimally
    /// combining sampling techniques for Monte Carlo rendering, 1995).
    ///
    /// accuracy  the rays have the same directions at all points of a plane, so that errors vary slowly: 2 %
    ///           with 256 rays. A small bright patch, such as a sunlit part of a floor, needs `lit`.
    /// cost      about 0.1 us per ray.
    GatheredIrradiance gathered_at(const ShadedScene& scene, std::size_t instance,
                                   const SurfacePoint& point) const {
        return gathered_at(scene, instance, point, gathering_rays);
    }
    /// Gathers with another number of rays.
    GatheredIrradiance gathered_at(const ShadedScene& scene, std::size_t instance, const SurfacePoint& point,
                                   int rays) const;
    /// Returns the irradiance of gathered_at.
    Rgb irradiance_at(const ShadedScene& scene, std::size_t instance, const SurfacePoint& point) const {
        return gathered_at(scene, instance, point).irradiance;
    }

    /// Computes the radiance of a point by indirect light. Specular lobes reflect diffuse radiance only.
    ///
    /// from      in the world, offset from the surface.
    /// arriving  the indirect irradiance of the point. [W/m^2]
    /// accuracy  24 rays per lobe, with the density of the lobe (lobe_rays.h).
    /// cost      about 5 us per lobe.
    Outgoing outgoing(const ShadedScene& scene, const Vec3f& from, const VertexBrdf& brdf,
                      const Rgb& arriving) const;

private:
    /// Returns the diffuse radiance of a hit surface; black if its back was hit.
    Rgb radiance_of(const ShadedScene& scene, const SurfaceHit& hit) const;
    /// Returns the irradiance from bright points.
    ///
    /// rays  the number of directions that are gathered as well.
    Rgb irradiance_from_bright_points(const Vec3f& from, const Vec3f& normal, int rays) const;
    /// Returns the share of a hit that the balance heuristic leaves to directions.
    ///
    /// cosine  between the normal of the point and the direction.
    float share_of_direction(const ShadedScene& scene, const SurfaceHit& hit, const Vec3f& direction,
                             float cosine) const;
};

/// Extrapolates colours to the hidden vertices of instances that have vertices inside other instances.
/// The colours of other instances are extrapolated by store_radiance.
///
/// hidden  by row: LightTransport::hidden.
void fill_hidden(const ShadedScene& scene, const ShadingGeometry& geometry,
                 std::span<const std::uint8_t> hidden, SceneColours& colours);

/// Smooths the irradiance of bounced light and assigns it to the vertices of the scene. Hidden vertices
/// (LightTransport) get the mean of their neighbours.
///
/// cost  that of LightTransport::smooth.
IndirectLight indirect_light(const ShadedScene& scene, const ShadingGeometry& geometry,
                             std::shared_ptr<const FineSurface> surface, const LightTransport& transport,
                             BouncedLight bounced);

}  // namespace haarfield
