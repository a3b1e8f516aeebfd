#pragma once
/// Rays along which specular lobes gather indirect light.

#include "shading/bounces/cosine_directions.h"
#include "shading/walk/vertex_shading.h"

namespace haarfield {

inline constexpr std::uint32_t lobe_rays = 24;  ///< Rays per lobe.

/// A ray of a lobe.
struct LobeRay {
    Vec3f direction;     ///< Unit length, above the surface.
    float weight;        ///< Factor of the radiance along the ray; does not contain VertexBrdf::specular.
    float metallic = 0;  ///< 1 - F of metals. Their colour is 1 - VertexBrdf::metallic * metallic.
};

/// Calls `visit(ray)` for each ray of a BRDF's specular lobes. The density of the rays is that of the lobe.
/// All BRDFs use the same points of Sobol's sequence.
template <class Visit>
void visit_lobe_rays(const VertexBrdf& brdf, const Visit& visit) {
    if (brdf.specular == Rgb(0.0f)) return;
    const Vec3f& normal = brdf.normal;
    const auto add = [&](const Vec3f& direction, float weight) {
        const float cosine = normal.dot(direction);
        if (!(cosine > 0)) return;
        if (brdf.cosine_weighted) weight *= cosine;
        LobeRay ray{direction, weight};
        if (brdf.metallic != Rgb(0.0f))
            ray.metallic = 1 - static_cast<float>(metallic_fresnel(double(cosine)));
        visit(ray);
    };
    constexpr float round = static_cast<float>(2 * pi) / lobe_rays;
    if (brdf.phong > 0) {
        const Axes<Vec3f> axes = axes_across(brdf.mirror);
        for (std::uint32_t k = 0; k < lobe_rays; ++k)
            add(power_direction(sobol_point(k), brdf.shininess, brdf.mirror, axes),
                brdf.phong * round / (brdf.shininess + 1));
    }
    if (brdf.blinn > 0) {
        const Vec3f eye = normal * (2 * normal.dot(brdf.mirror)) - brdf.mirror;
        const Axes<Vec3f> axes = axes_across(normal);
        for (std::uint32_t k = 0; k < lobe_rays; ++k) {
            const Vec3f half = power_direction(sobol_point(k), brdf.blinn_exponent, normal, axes);
            const float along = half.dot(eye);
            if (along > 0)
                add(half * (2 * along) - eye, brdf.blinn * 4 * along * round / (brdf.blinn_exponent + 1));
        }
    }
}

}  // namespace haarfield
