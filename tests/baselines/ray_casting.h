#pragma once
/// The baseline of ray casting: Monte Carlo integration with Embree's packets of 16.

#include <cstdint>
#include <memory>

#include "tests/baselines/scene_integrals.h"

namespace haarfield::baseline {

/// A Monte Carlo integrator with multiple importance sampling.
///
/// Half of the rays sample the texels of the lighting, half sample BRDF and cosine. Both halves are
/// stratified and combined by the balance heuristic (Veach and Guibas 1995). The light samples are drawn once
/// for all vertices, in 64 sets. Directions below the horizon cost no ray.
class RayCaster {
public:
    /// Builds a BVH of all instances with the occluders of texel_integrals: coarse meshes, whose closed
    /// pieces block with their front faces only, because some vertices lie slightly below a simplified
    /// surface.
    RayCaster(const ShippedScene& scene, const TexelIntegrals& integrals);

    /// Sets the number of rays per vertex, a multiple of 2.
    void use_rays(int rays);

    /// Estimates the product integral of all seven functions. Equal vertices and seeds give equal estimates.
    Rgb operator()(const VertexTexels& vertex, std::uint32_t seed);

private:
    struct Sample {
        Vec3f direction;
        Rgb value;  ///< Contribution of the ray if it is unoccluded.
    };

    /// The radiance of the lighting in a direction, and the density of light samples. [1/sr]
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
    std::vector<float> probability_;  ///< Probability of a light sample, by texel.
    std::vector<double> cumulative_;  ///< Cumulative probability, by texel.
    int rays_ = 0;
    std::vector<LightSample> light_samples_;  ///< rays_ / 2 for each set.
    std::vector<Sample> samples_;
    std::shared_ptr<void> scene_;  ///< Embree's.
};

}  // namespace haarfield::baseline
