#pragma once
/// The reflectance of surfaces.

#include "shading/walk/brdf.h"

#include <cstdint>

namespace haarfield {

/// The definition of the specular term.
enum class LobeConvention : std::uint8_t {
    /// One Phong lobe, energy-normalised and cosine-weighted:
    ///     outgoing = int L [ diffuse/pi + specular (n+2)/(2 pi) max(0,R.w)^n ] max(0,N.w) dw
    physical,
    /// POV-Ray's finish under a light source of radiance * solid angle / pi: the specular term has no cosine,
    /// and is zero for light from below the horizon:
    ///     outgoing = int L/pi [ diffuse max(0,N.w)
    ///                + specular (phong max(0,R.w)^n + blinn max(0,N.H)^(1/roughness)) tint ] [N.w > 0] dw,
    ///     tint     = 1 - metallic (1 - pigment) (1 - F(N.w)).
    /// F: metallic_fresnel.
    povray,
};

/// A diffuse (Lambertian) and a specular term. R is the view direction mirrored about the normal N; H is
/// halfway between the view direction and w.
struct Material {
    Rgb diffuse{0.5f, 0.5f, 0.5f};  ///< Albedo, each channel in [0, 1].
    Rgb specular{0, 0, 0};          ///< Specular colour, each channel in [0, 1].
    float shininess = 50;           ///< Exponent n, 1 to 1000.
    LobeConvention convention = LobeConvention::physical;

    /// @name For the povray convention only.
    /// @{
    float phong = 1;          ///< Weight of the lobe about R. >= 0.
    float blinn = 0;          ///< Weight of the lobe about H, POV-Ray's `specular`. >= 0.
    float roughness = 0.05f;  ///< Of the lobe about H, 0.0005 to 1.
    float metallic = 0;       ///< In [0, 1].
    Rgb pigment{1, 1, 1};     ///< Tints metallic specular light; diffuse is a multiple of it.
    /// @}

    bool operator==(const Material&) const = default;
};

/// Returns the BRDF of a material at a point.
///
/// normal, mirror  N and R; unit vectors.
template <class Real>
BasicBrdf<Real> surface_brdf(const Material& material, const Imath::Vec3<Real>& normal = Imath::Vec3<Real>(0),
                             const Imath::Vec3<Real>& mirror = Imath::Vec3<Real>(0)) {
    using Colour = typename BasicBrdf<Real>::Colour;
    const Real over_pi = static_cast<Real>(1 / pi), shininess = Real(material.shininess);
    BasicBrdf<Real> brdf{normal, mirror, Colour(material.diffuse) * over_pi,
                         Colour(material.specular) * over_pi};
    brdf.cosine_weighted = material.convention == LobeConvention::physical;
    if (brdf.cosine_weighted) {
        brdf.specular *= (shininess + 2) * Real(0.5);
        brdf.lobes[0] = {LobeAxis::mirror, 1, shininess};
    } else {
        brdf.lobes = {{{LobeAxis::mirror, Real(material.phong), shininess},
                       {LobeAxis::half_vector, Real(material.blinn), 1 / Real(material.roughness)}}};
        brdf.metallic = (Colour(1) - Colour(material.pigment)) * Real(material.metallic);
    }
    return brdf;
}

/// Returns BRDF times cosine: the factor of L in the conventions' integrals above. [1/sr]
///
/// normal, mirror, light  N, R and w; unit vectors.
/// accuracy               against POV-Ray's povray convention: that of its pictures.
Components<Vec3d> reflectance(const Material& material, const Vec3d& normal, const Vec3d& mirror,
                              const Vec3d& light);

}  // namespace haarfield
