#pragma once
/// How a surface answers light.

#include "shading/scene/outgoing.h"

#include <cstdint>

namespace haarfield {

/// How the highlights are meant.
enum class LobeConvention : std::uint8_t {
    /// One Phong lobe, energy-normalised and cosine-weighted:
    ///     outgoing = int L [ diffuse/pi + specular (n+2)/(2 pi) max(0,R.w)^n ] max(0,N.w) dw
    physical,
    /// What POV-Ray's finish does under a light source of radiance * solid angle / pi: no cosine on the
    /// highlights, but nothing from below the horizon:
    ///     outgoing = int L/pi [ diffuse max(0,N.w)
    ///                + specular (phong max(0,R.w)^n + blinn max(0,N.H)^(1/roughness)) tint ] [N.w > 0] dw,
    ///     tint     = 1 - metallic (1 - pigment) (1 - F(N.w)).
    /// F: metallic_fresnel.
    povray,
};

/// A diffuse (Lambertian) term and highlights. R is the view direction mirrored about the normal N, H lies
/// halfway between the view direction and w.
struct Material {
    Rgb diffuse{0.5f, 0.5f, 0.5f};  ///< Albedo, each channel in [0, 1].
    Rgb specular{0, 0, 0};          ///< Colour of the highlights, each channel in [0, 1].
    float shininess = 50;           ///< Exponent n, 1 to 1000.
    LobeConvention convention = LobeConvention::physical;

    /// @name In the povray convention only.
    /// @{
    float phong = 1;          ///< Weight of the lobe about R. >= 0.
    float blinn = 0;          ///< Weight of the lobe about H, POV-Ray's `specular`. >= 0.
    float roughness = 0.05f;  ///< Of the latter, 0.0005 to 1.
    float metallic = 0;       ///< In [0, 1].
    Rgb pigment{1, 1, 1};     ///< What metallic highlights are tinted with; diffuse is a multiple of it.
    /// @}

    bool operator==(const Material&) const = default;
};

/// By how much a metal's highlight has the colour of the light rather than its own: 0 where light comes along
/// the normal, 1 at the horizon.
///
/// cosine  of the angle of incidence, in [0, 1].
/// source  POV-Ray 3.7, `metallic`: an empirical Fresnel reflectivity.
double metallic_fresnel(double cosine);

/// Returns BRDF times cosine: the factor of L in the conventions' integrals above. [1/sr]
///
/// normal, mirror, light  N, R and w; unit vectors.
/// accuracy               against POV-Ray's povray convention: that of its pictures.
Components<Vec3d> reflectance(const Material& material, const Vec3d& normal, const Vec3d& mirror,
                              const Vec3d& light);

}  // namespace haarfield
