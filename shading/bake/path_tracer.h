#pragma once
/// Indirect light by path tracing, in packets of rays.

#include "shading/bake/path_samples.h"
#include "shading/bake/ray_scene.h"
#include "shading/bake/renderer.h"

namespace haarfield {

/// Traces paths from points of a scene. Threads may share it.
///
/// It uses neither wavelets, fields, the splitting of light into sources, the transport matrix nor
/// interpolated light. At each surface that a path meets, it adds the light of all lamps, and samples the
/// environment and the emitters by one shadow ray each. The next direction of the path also samples these
/// two; the balance heuristic combines both. Surfaces are diffuse, with their tints; their backs are black.
///
/// The paths of a point advance together. Results do not depend on other points or on threads.
class PathTracer {
public:
    /// The referenced objects must outlive it.
    ///
    /// surface  of the same scene.
    PathTracer(const RayScene& rays, const FineSurface& surface);

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
    /// accuracy  unbiased; paths are terminated by Russian roulette. The deviation is that of independent
    ///           paths, which is larger than the true one.
    /// cost      about 1 us per path.
    Estimate indirect_irradiance(const Vec3f& from, const Vec3f& normal, double certainty, std::uint32_t most,
                                 std::uint32_t seed) const;

    /// Estimates the radiance of a point in the world by indirect light.
    ///
    /// from      off the surface.
    /// paths     of the diffuse component. Each specular lobe has a quarter as many.
    /// seed      different seeds are independent estimates.
    /// bounces   reflections before the light reaches the point.
    /// accuracy  unbiased.
    Outgoing indirect_radiance(const Vec3f& from, const VertexBrdf& brdf, std::uint32_t paths,
                               std::uint32_t seed, int bounces = any_bounces) const;
    /// Estimates it by paths with given samples.
    Outgoing indirect_radiance(const Vec3f& from, const VertexBrdf& brdf, const PathSamples& samples,
                               int bounces) const;

private:
    /// A diffuse surface element.
    struct PathVertex {
        Vec3f from, normal;
        Rgb reflectance;  ///< Albedo / pi. [1/sr]
    };

    /// The first ray of a path.
    struct PathStart {
        Vec3f direction;     ///< Unit length.
        std::uint32_t path;  ///< Number in the samples.
    };

    class PathBatch;

    /// Estimates the diffuse radiance of the surfaces that rays meet, by one path each; black if a ray meets
    /// none.
    void trace(const Vec3f& from, std::span<const PathStart> starts, const PathSamples& samples, int bounces,
               std::span<Rgb> radiance) const;

    PathVertex path_vertex(const SurfaceHit& hit, const Vec3f& position) const;

    const RayScene& rays_;
    const FineSurface& surface_;
    std::vector<float> offsets_;  ///< Of rays from the surfaces, by instance. [m]
};

}  // namespace haarfield
