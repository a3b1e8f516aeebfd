#pragma once
/// Approximates emissive surfaces by dense sets of lamps, for POV-Ray.
///
/// Lamps replace POV-Ray's radiosity, which is biased where light is concentrated, adds bounces that a bake
/// may not have, and ignores specular reflection. A small surface patch is a spotlight with tightness 1 and
/// an opening angle of 90 degrees. Its light falls off with the cosine and with the square of the distance,
/// exactly as the light of the patch does.

#include <span>
#include <vector>

#include "bridge/povray/lit_points.h"
#include "shading/scene/emitter.h"
#include "shading/scene/lamp.h"

namespace haarfield {

/// The position of a lamp in its patch.
enum class PatchPlace {
    middle,
    random,  ///< A pseudo-random position per patch, fixed by a seed: a second set, as accurate as `middle`.
};

/// Returns lamps that emit the light of the emitters.
///
/// emitters  in world coordinates.
/// count     the number of lamps, at least 1. If there are more triangles, a subset represents all of them.
/// lit       if given, the cutter subdivides by power only up to half of the patches. It then subdivides the
///           patches with the largest error in the irradiance of these points, such as patches close to a
///           point.
/// lift      the distance of lamps from the surface, which prevents self-shadowing. [m]
/// accuracy  relative error of a patch's irradiance at d times its size: 1 / (2 d^2). Useless next to the
///           patch.
std::vector<Lamp> emitter_lamps(std::span<const Emitter> emitters, std::size_t count, PatchPlace place,
                                float lift, const LitPoints* lit = nullptr);

}  // namespace haarfield
