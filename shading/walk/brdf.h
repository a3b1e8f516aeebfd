#pragma once
/// The BRDF of a point as data: colours and specular lobes, and its evaluation for single directions.

#include <array>
#include <cstdint>
#include <type_traits>

#include "shading/walk/outgoing.h"

namespace haarfield {

/// The angle with which a specular lobe falls off.
enum class LobeAxis : std::uint8_t {
    mirror,       ///< Between the light and R, the view direction mirrored about the normal.
    half_vector,  ///< Between the normal N and H, which is halfway between the view direction and the light.
};

/// A specular lobe: weight times a power of the cosine of its angle; zero from a right angle on.
template <class Real>
struct BasicLobe {
    LobeAxis axis = LobeAxis::mirror;
    Real weight = 0;    ///< >= 0; 0: there is no lobe.
    Real exponent = 1;  ///< >= 0; 0: constant.

    /// Returns the exponent of a lobe about R that has the same width in the plane of incidence. There, the
    /// half vector rotates half as far as the light.
    Real mirror_exponent() const {
        return axis == LobeAxis::half_vector ? std::max(Real(1), exponent / 4) : exponent;
    }
    /// Returns the lobe's integral over that of a cosine power about R, for H near N.
    Real mean_over_power() const { return axis == LobeAxis::half_vector ? Real(4) : Real(1); }
};
/// A lobe as it is evaluated in bakes.
using Lobe = BasicLobe<float>;

inline constexpr std::size_t most_lobes = 2;  ///< Of a BRDF.

/// A BRDF at a point. From incident radiance L it computes
///     outgoing = int L [ diffuse max(0,N.w) + specular (1 - metallic (1 - F(N.w))) lobes c ] dw.
/// If the specular term is cosine-weighted, c is max(0,N.w), otherwise 1 above and 0 below the horizon. F:
/// metallic_fresnel.
template <class Real>
struct BasicBrdf {
    using Vector = Imath::Vec3<Real>;                                            ///< A direction.
    using Colour = std::conditional_t<std::is_same_v<Real, float>, Rgb, Vec3d>;  ///< Linear RGB.

    Vector normal{0}, mirror{0};                      ///< N and R.
    Colour diffuse{0};                                ///< Albedo / pi. [1/sr]
    Colour specular{0};                               ///< Including its normalisation. [1/sr]
    std::array<BasicLobe<Real>, most_lobes> lobes{};  ///< At fixed places; those without weight do not exist.
    Colour metallic{0};  ///< Fraction of specular light that a metal absorbs along N. In [0, 1].
    bool cosine_weighted = false;

    bool has_specular() const { return specular != Colour(0); }  ///< True if there is a specular term.
    bool is_metallic() const { return metallic != Colour(0); }   ///< True if F matters.
    /// Returns V, the view direction.
    Vector eye() const { return normal * (2 * normal.dot(mirror)) - mirror; }
};
/// A BRDF as it is evaluated in bakes.
using VertexBrdf = BasicBrdf<float>;

/// Returns how far the specular light of a metal has the colour of the light instead of the pigment: 0 for
/// light along the normal, 1 at the horizon.
///
/// cosine  of the angle of incidence, in [0, 1].
/// source  POV-Ray 3.7, `metallic`: an empirical Fresnel reflectivity.
double metallic_fresnel(double cosine);

/// Returns the value of a lobe of weight 1 for light from a direction.
///
/// spread  of the light about its direction; see lobe_mean-inl.h. 0: light from one direction.
/// @{
float lobe_value(const Lobe& lobe, const VertexBrdf& brdf, const Vec3f& light, float spread = 0);
double lobe_value(const BasicLobe<double>& lobe, const BasicBrdf<double>& brdf, const Vec3d& light,
                  double spread = 0);
/// @}

/// Returns the specular component of BRDF times cosine for light from one direction, a unit vector. [1/sr]
///
/// spread    as in lobe_value.
/// accuracy  in single precision, 1e-5 of the lobe's peak.
template <class Real>
typename BasicBrdf<Real>::Colour specular_reflectance(const BasicBrdf<Real>& brdf,
                                                      const Imath::Vec3<Real>& light, Real spread = 0) {
    using Colour = typename BasicBrdf<Real>::Colour;
    const Real cosine = brdf.normal.dot(light);
    if (!(cosine > 0) || !brdf.has_specular()) return Colour(0);
    Real sum = 0;
    for (const BasicLobe<Real>& lobe : brdf.lobes)
        if (lobe.weight > 0) sum += lobe.weight * lobe_value(lobe, brdf, light, spread);
    if (!(sum > 0)) return Colour(0);
    if (brdf.cosine_weighted) sum *= cosine;
    Colour tint(1);
    if (brdf.is_metallic()) tint -= brdf.metallic * (1 - static_cast<Real>(metallic_fresnel(double(cosine))));
    return brdf.specular * tint * sum;
}

/// Returns BRDF times cosine for light from one direction, a unit vector: the factor of L in the BRDF's
/// integral. [1/sr]
///
/// accuracy  as specular_reflectance.
Outgoing reflectance(const VertexBrdf& brdf, const Vec3f& light);

}  // namespace haarfield
