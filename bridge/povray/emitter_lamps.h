#pragma once
/// Glowing surfaces as dense sets of lamps, for POV-Ray.
///
/// Lamps, not POV-Ray's radiosity: radiosity is biased where light is concentrated, adds bounces that a bake
/// may not have, and knows no highlights. A small patch of a surface is a spot with tightness 1 and a right
/// angle, whose light falls off with the cosine, and with the square of the distance: exactly what it sheds.

#include <span>
#include <vector>

#include "bridge/povray/lit_points.h"
#include "shading/scene/emitter.h"
#include "shading/scene/lamp.h"

namespace haarfield {

/// Where in its patch a lamp stands.
enum class PatchPlace {
    middle,
    random,  ///< A fixed place for each patch: another set of lamps, as good as that of the middles.
};

/// Lamps that shed what emitters do.
///
/// emitters  in the world.
/// count     wanted, at least 1. Where there are more triangles, some stand for all.
/// lit       if given, only the first half of the patches is cut by power. The others are cut where the error
///           of the irradiance of these points is largest, such as right beside them.
/// lift      by how much they stand off the surface, so that it does not shadow them. [m]
/// accuracy  of the irradiance of a patch at d times its size: 1 / (2 d^2); right beside it, useless.
std::vector<Lamp> emitter_lamps(std::span<const Emitter> emitters, std::size_t count, PatchPlace place,
                                float lift, const LitPoints* lit = nullptr);

}  // namespace haarfield
