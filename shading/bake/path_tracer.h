#pragma once
/// Indirect light by paths: the slow truth that bounces are measured against.

#include <cstdint>

#include "shading/bake/renderer.h"
#include "shading/bake/source_choice.h"

namespace haarfield {

/// Follows light backwards from points of a scene. Safe to share between threads.
///
/// It knows nothing of wavelets, fields, the transport matrix or interpolated light: at each surface that a
/// path meets, all lamps and emitters shed on it, one light of the environment's sources is asked for by a
/// shadow ray, and what the path meets at its end, when it leaves the scene, is the rest of the
/// environment. Surfaces have their diffuse term, with their tints; their backs are black.
class PathTracer {
public:
    /// What the references are of must outlive it.
    PathTracer(const ShadedScene& scene, const FineSurface& surface, const ShadowRays& rays,
               const SourceRule& sources = {});

    /// An irradiance, and how uncertain it is.
    struct Estimate {
        Rgb irradiance{0.0f};  ///< By light that was reflected once at least. [W/m^2]
        Rgb deviation{0.0f};   ///< Standard deviation of it. [W/m^2]
    };

    /// Indirect irradiance of a point in the world.
    ///
    /// from      off the surface.
    /// certainty ends where the deviation is at most this part of the luminance,
    /// most      or after so many paths; they come by 1024.
    /// seed      other seeds are other paths.
    /// accuracy  unbiased; paths end by chance, in proportion to what they carry.
    /// cost      some microseconds a path.
    Estimate indirect_irradiance(const Vec3f& from, const Vec3f& normal, double certainty, std::uint32_t most,
                                 std::uint32_t seed) const;

private:
    /// What a diffuse point sheds of the light of lamps and emitters.
    Rgb near_light(const Vec3f& from, const Vec3f& normal, const Rgb& reflectance) const;

    const ShadedScene& scene_;
    const FineSurface& surface_;
    const ShadowRays& rays_;
    std::vector<PlacedLamp> lamps_;
    EmitterTree emitters_;
    LatLongImage smooth_;
    SourceChoice sources_;
};

}  // namespace haarfield
