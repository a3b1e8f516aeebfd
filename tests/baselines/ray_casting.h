#pragma once
/// The baseline of ray casting: the same integral by Monte Carlo, with Embree's packets of 16.

#include <cstdint>
#include <memory>

#include "tests/baselines/scene_integrals.h"

namespace haarfield::baseline {

/// Half of the rays go to where the light is (by texel of the lighting), half to where BRDF and cosine are
/// large, combined by the balance heuristic (Veach and Guibas 1995); both sets are stratified. What goes to
/// the light is drawn once for all vertices, in 64 sets. Directions below the horizon cost no ray.
class RayCaster {
public:
    /// All instances of the scene, as texel_integrals sees them: coarse meshes, closed pieces by their front
    /// faces, since some vertices lie a little below a simplified surface.
    RayCaster(const ShippedScene& scene, const TexelIntegrals& integrals);

    /// So many rays a vertex from now on, a multiple of 2.
    void use_rays(int rays);

    /// An estimate of the product integral of all seven functions; the same vertex and seed, the same
    /// estimate.
    Rgb operator()(const VertexTexels& vertex, std::uint32_t seed);

private:
    struct Sample {
        Vec3f direction;
        Rgb value;  ///< What the ray brings if nothing is in its way.
    };

    /// Its radiance in a direction, and the density of light samples there. [1/sr]
    struct Light {
        Rgb radiance;
        float density;
    };
    struct LightSample {
        Vec3f direction;
        Light light;
    };

    Light light_from(const Vec3f& direction) const;
    void add_sample(const VertexTexels& vertex, const Vec3f& direction, const Light& light);
    Rgb sum_of_open(const Vec3f& origin) const;

    int size_;
    std::vector<Rgb> radiance_;       ///< By texel.
    std::vector<float> probability_;  ///< That a light sample falls in the texel.
    std::vector<double> cumulative_;  ///< Of the texels up to and including this one.
    int rays_ = 0;
    std::vector<LightSample> light_samples_;  ///< rays_ / 2 for each set.
    std::vector<Sample> samples_;
    std::shared_ptr<void> scene_;  ///< Embree's.
};

}  // namespace haarfield::baseline
