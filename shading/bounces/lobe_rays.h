#pragma once
/// The sampling of specular lobes, and rays along which lobes gather indirect light.

#include "shading/bounces/cosine_directions.h"
#include "shading/walk/brdf.h"

namespace haarfield {

/// Samples directions with the density of the lobes of a BRDF, which must outlive it.
class LobeSampling {
public:
    /// Prepares the frames of the lobes.
    explicit LobeSampling(const VertexBrdf& brdf)
        : brdf_(brdf),
          eye_(brdf.eye()),
          normal_axes_(axes_across(brdf.normal)),
          mirror_axes_(axes_across(brdf.mirror)) {}

    /// Returns a direction, which may lie below the surface. Not quite of unit length.
    ///
    /// place  in the unit square.
    Vec3f direction(const Lobe& lobe, const Vec2f& place) const {
        if (lobe.axis == LobeAxis::mirror)
            return power_direction(place, lobe.exponent, brdf_.mirror, mirror_axes_);
        const Vec3f half = power_direction(place, lobe.exponent, brdf_.normal, normal_axes_);
        return half * (2 * half.dot(eye_)) - eye_;
    }
    /// Returns a lobe of weight 1 over the density of directions. [sr]
    float over_density(const Lobe& lobe, const Vec3f& direction) const {
        const float area = static_cast<float>(2 * pi) / (lobe.exponent + 1);
        return lobe.axis == LobeAxis::half_vector ? area * 4 * (eye_ + direction).normalized().dot(eye_)
                                                  : area;
    }
    /// Returns the density of a direction above the surface. [1/sr]
    float density(const Lobe& lobe, const Vec3f& direction) const {
        const float value = lobe_value(lobe, brdf_, direction);
        return value > 0 ? value / over_density(lobe, direction) : 0.0f;
    }

private:
    const VertexBrdf& brdf_;
    const Vec3f eye_;
    const Axes<Vec3f> normal_axes_, mirror_axes_;
};

inline constexpr std::uint32_t lobe_rays = 24;  ///< Rays per lobe.

/// A ray of a lobe.
struct LobeRay {
    Vec3f direction;     ///< Unit length, above the surface.
    float weight;        ///< Factor of the radiance along the ray; does not contain VertexBrdf::specular.
    float metallic = 0;  ///< 1 - F of metals. Their colour is 1 - VertexBrdf::metallic * metallic.
};

/// Calls `visit(k, ray)` for rays of a BRDF's specular lobes. The density of the rays is that of the lobe.
///
/// rays   per lobe.
/// place  (std::uint32_t k) -> Vec2f: a point in the unit square.
template <class Place, class Visit>
void visit_lobe_rays(const VertexBrdf& brdf, std::uint32_t rays, const Place& place, const Visit& visit) {
    if (!brdf.has_specular()) return;
    const LobeSampling sampling(brdf);
    for (const Lobe& lobe : brdf.lobes)
        for (std::uint32_t k = 0; k < rays && lobe.weight > 0; ++k) {
            const Vec3f direction = sampling.direction(lobe, place(k));
            const float cosine = brdf.normal.dot(direction);
            if (!(cosine > 0)) continue;
            LobeRay ray{direction, lobe.weight * sampling.over_density(lobe, direction) / float(rays)};
            if (brdf.cosine_weighted) ray.weight *= cosine;
            if (brdf.is_metallic()) ray.metallic = 1 - static_cast<float>(metallic_fresnel(double(cosine)));
            visit(k, ray);
        }
}

/// Calls `visit(ray)` for `lobe_rays` rays of each lobe. All BRDFs use the same points of Sobol's sequence.
template <class Visit>
void visit_lobe_rays(const VertexBrdf& brdf, const Visit& visit) {
    visit_lobe_rays(brdf, lobe_rays, sobol_point, [&](std::uint32_t, const LobeRay& ray) { visit(ray); });
}

}  // namespace haarfield
