#pragma once
/// Radiance of points by lamps: shadow rays to the places of the lamps, and the BRDF.

#include "shading/bake/source_light.h"
#include "shading/scene/lamp.h"
#include "shading/scene/material.h"
#include "shading/scene/vertex_loop.h"

namespace haarfield {

/// Adds the light of unoccluded lamps, behind filters, to the outgoing radiance of each receiver.
///
/// receivers  neighbours in space next to each other.
/// radiance   by receiver. [W/(m^2 sr)]
/// accuracy   unshadowed, 1e-5 of POV-Ray's.
/// cost       60 to 120 ns per place of a lamp that a receiver faces; 20 ns per lamp that it does not face.
void add_lamp_light(const ShadowRays& rays, std::span<const PlacedLamp> lamps,
                    std::span<const ShadingPoint> receivers, std::span<Outgoing> radiance);

/// Returns the radiance of one point by lamps, in double precision.
Components<Vec3d> radiance_from_lamps(std::span<const PlacedLamp> lamps, const ShadowRays& rays,
                                      const Material& material, const ShadingPoint& at);

}  // namespace haarfield
