#pragma once
/// Indirect light by path tracing: the slow reference for bounces.

#include <cstdint>
#include <random>

#include "shading/bake/environment_sampler.h"
#include "shading/bake/renderer.h"
#include "shading/bake/source_choice.h"

namespace haarfield {

/// Traces paths from points of a scene. Threads may share it.
///
/// It uses neither wavelets, fields, the transport matrix nor interpolated light. At each surface that a path
/// meets, it adds the light of all lamps, and that of one light of the environment's sources by a shadow ray.
/// Emitters are sampled by area and by the next direction of the path, combined by the balance heuristic. A
/// path that leaves the scene adds the remainder of the environment. Surfaces are diffuse, with their tints;
/// their backs are black.
class PathTracer {
public:
    /// The referenced objects must outlive it.
    PathTracer(const ShadedScene& scene, const FineSurface& surface, const ShadowRays& rays,
               const SourceRule& sources = {});

    /// An irradiance, and its uncertainty.
    struct Estimate {
        Rgb irradiance{0.0f};  ///< By light that was reflected at least once. [W/m^2]
        Rgb deviation{0.0f};   ///< Standard deviation of `irradiance`. [W/m^2]
    };

    /// Returns the indirect irradiance of a point in the world.
    ///
    /// from      off the surface.
    /// certainty stops when the deviation is at most this fraction of the luminance.
    /// most      largest number of paths; paths are traced in batches of 1024.
    /// seed      selects other paths.
    /// accuracy  unbiased; paths are terminated by Russian roulette.
    /// cost      some microseconds per path.
    Estimate indirect_irradiance(const Vec3f& from, const Vec3f& normal, double certainty, std::uint32_t most,
                                 std::uint32_t seed) const;

    /// Estimates the radiance of a point in the world by indirect light. Specular lobes have the rays of
    /// IndirectLight::outgoing, each with one path.
    ///
    /// from      off the surface.
    /// paths     of the diffuse component.
    /// seed      different seeds are independent estimates.
    /// accuracy  unbiased.
    Outgoing indirect_radiance(const Vec3f& from, const VertexBrdf& brdf, std::uint32_t paths,
                               std::uint32_t seed) const;

private:
    /// Random numbers in [0, 1).
    class Numbers {
    public:
        explicit Numbers(std::uint32_t seed) : random_(seed) {}
        float operator()() { return float(random_() >> 8) / float(1 << 24); }

    private:
        std::mt19937 random_;
    };

    /// Estimates the diffuse radiance of the surface that a ray meets, by one path; black if it meets none.
    Rgb radiance_along(const Vec3f& from, const Vec3f& direction, Numbers& number) const;

    /// A diffuse surface element.
    struct PathVertex {
        Vec3f from, normal;
        Rgb reflectance;  ///< Albedo / pi. [1/sr]
    };

    static PathVertex path_vertex(const ShadedScene& scene, const SurfaceHit& hit, const Vec3f& position);

    Rgb light_of_lamps(const PathVertex& at) const;

    /// Estimates the light of one of the environment's sources.
    Rgb light_of_sources(const PathVertex& at, Numbers& number) const;

    /// Estimates the light of a point on an emitter. radiance_by_direction() has the rest.
    Rgb light_of_emitters(const PathVertex& at, Numbers& number) const;

    /// Returns the radiance of the emitter in a direction with cosine density, weighted by the balance
    /// heuristic. [W/(m^2 sr)]
    Rgb radiance_by_direction(const PathVertex& at, const Vec3f& direction) const;

    bool is_blocked(const Vec3f& from, const LightSample& light) const;

    const ShadedScene& scene_;
    const FineSurface& surface_;
    const ShadowRays& rays_;
    std::vector<PlacedLamp> lamps_;
    EmitterSampler emitters_;
    LatLongImage smooth_;
    SourceChoice sources_;
};

}  // namespace haarfield
