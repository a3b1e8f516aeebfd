#pragma once
/// The baseline of spherical harmonics: products of two functions at a time by tripling coefficients.
///
/// Real harmonics Y_lm of degree l < order, with index l (l + 1) + m, orthonormal over the sphere. The
/// product of two functions is projected back on them and loses all higher degrees. This loss and the missing
/// fine detail are the error of the method. (Sloan, Kautz and Snyder 2002; Ng et al. 2004, section 4; Zhou et
/// al. 2005.)

#include <cstdint>
#include <span>
#include <vector>

#include "fields/base/vector.h"

namespace haarfield::baseline {

/// Evaluates all harmonics in a unit direction: order^2 values.
std::vector<double> harmonics(int order, const Vec3d& direction);

/// The non-zero int Y_i Y_j Y_k dw for i <= j, by k.
struct TriplingCoefficients {
    struct Term {
        std::uint16_t i, j;
        float coefficient;
    };
    int order = 0;
    std::vector<std::vector<Term>> terms;  ///< Indexed by k.
};

/// Computes the coefficients by Gauss-Legendre quadrature that is exact for their degree.
///
/// accuracy  1e-12.
/// cost      about 0.3 s for order 10.
TriplingCoefficients tripling_coefficients(int order);

/// The number of vertices per batch, one per lane, so that the terms are the same for all lanes.
inline constexpr std::size_t harmonics_batch = 16;

/// Coefficients of one function at the vertices of a batch: order^2 times harmonics_batch.
using HarmonicsBatch = std::vector<float>;

/// Computes the projection of f g.
void harmonics_product(const TriplingCoefficients& coefficients, const HarmonicsBatch& f,
                       const HarmonicsBatch& g, HarmonicsBatch& product);

/// Computes (f_1 f_2) f_3 ..., and its inner product with the light's coefficients, for each vertex. k >= 1.
/// Keeps its buffers.
class RecursiveHarmonicsProduct {
public:
    explicit RecursiveHarmonicsProduct(int order) : coefficients_(tripling_coefficients(order)) {}

    void operator()(std::span<const Rgb> light, std::span<const HarmonicsBatch> factors,
                    std::span<Rgb> radiance);

private:
    TriplingCoefficients coefficients_;
    HarmonicsBatch product_, next_;
};

/// Projection of texels on the cubemap (6 * size^2) to coefficients.
class HarmonicsProjection {
public:
    HarmonicsProjection(int order, int face_size);

    std::vector<float> operator()(std::span<const float> texels) const;

    /// Projects the lighting, whose texels contain their solid angle (lighting.h).
    std::vector<Rgb> of_light(std::span<const Rgb> texels) const;

private:
    std::size_t count_;
    std::vector<float> solid_angle_;  ///< Indexed by texel.
    std::vector<float> harmonics_;    ///< count_ values per texel.
};

}  // namespace haarfield::baseline
