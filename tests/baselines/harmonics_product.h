#pragma once
/// The baseline of spherical harmonics: products of two functions at a time by tripling coefficients.
///
/// Real harmonics Y_lm of degree l < order, numbered l (l + 1) + m, orthonormal over the sphere. The product
/// of two functions is projected back on them, so that each product loses what lies above; with its neglect
/// of everything fine this makes the method's error. (Sloan, Kautz and Snyder 2002; Ng et al. 2004, section
/// 4; Zhou et al. 2005.)

#include <cstdint>
#include <span>
#include <vector>

#include "fields/base/vector.h"

namespace haarfield::baseline {

/// All of them at a unit direction, order^2 values.
std::vector<double> harmonics(int order, const Vec3d& direction);

/// int Y_i Y_j Y_k dw where it does not vanish, for i <= j; by k.
struct TriplingCoefficients {
    struct Term {
        std::uint16_t i, j;
        float coefficient;
    };
    int order = 0;
    std::vector<std::vector<Term>> terms;  ///< By k.
};

/// By Gauss-Legendre quadrature that is exact for the degree.
///
/// accuracy  1e-12.
/// cost      some 0.3 s for order 10.
TriplingCoefficients tripling_coefficients(int order);

/// Sixteen vertices at a time, one a lane: the terms are then the same for all lanes.
inline constexpr std::size_t harmonics_batch = 16;

/// Coefficients of one function at the vertices of a batch: order^2 times harmonics_batch.
using HarmonicsBatch = std::vector<float>;

/// f g, projected.
void harmonics_product(const TriplingCoefficients& coefficients, const HarmonicsBatch& f,
                       const HarmonicsBatch& g, HarmonicsBatch& product);

/// (f_1 f_2) f_3 ..., and its inner product with the light's coefficients, by vertex. k >= 1. Keeps its
/// memory.
class RecursiveHarmonicsProduct {
public:
    explicit RecursiveHarmonicsProduct(int order) : coefficients_(tripling_coefficients(order)) {}

    void operator()(std::span<const Rgb> light, std::span<const HarmonicsBatch> factors,
                    std::span<Rgb> radiance);

private:
    TriplingCoefficients coefficients_;
    HarmonicsBatch product_, next_;
};

/// Texels on the cubemap (6 * size^2) to coefficients.
class HarmonicsProjection {
public:
    HarmonicsProjection(int order, int face_size);

    std::vector<float> operator()(std::span<const float> texels) const;

    /// Of the lighting, whose texels hold their solid angle (lighting.h).
    std::vector<Rgb> of_light(std::span<const Rgb> texels) const;

private:
    std::size_t count_;
    std::vector<float> solid_angle_;  ///< By texel.
    std::vector<float> harmonics_;    ///< By texel, count_ of them each.
};

}  // namespace haarfield::baseline
