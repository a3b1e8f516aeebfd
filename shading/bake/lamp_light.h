#pragma once
/// What lamps add to the radiance of points: shadow rays to their places, and the BRDF.

#include "shading/bake/source_light.h"
#include "shading/scene/lamp.h"
#include "shading/scene/material.h"
#include "shading/scene/vertex_loop.h"

namespace haarfield {

/// Adds to each receiver's outgoing radiance what the lamps shed on it that nothing blocks.
///
/// receivers  neighbours in space beside each other.
/// radiance   as many. [W/(m^2 sr)]
/// diffuse    as many, to which what the diffuse term makes of it is added, too; or none.
/// accuracy   unshadowed, 1e-5 of POV-Ray's.
/// cost       60 to 120 ns a place of a lamp that a receiver faces; 20 ns a lamp that it does not.
void add_lamp_light(const ShadowRays& rays, std::span<const PlacedLamp> lamps,
                    std::span<const SourceReceiver> receivers, std::span<Rgb> radiance,
                    std::span<Rgb> diffuse = {});

/// The same for one point, in double.
///
/// from  in the world: where the point looks from, off the surface beside it.
Vec3d radiance_from_lamps(std::span<const PlacedLamp> lamps, const ShadowRays& rays, const Vec3f& from,
                          const Material& material, const VertexView& view);

}  // namespace haarfield
