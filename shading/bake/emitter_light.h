#pragma once
/// What glowing surfaces add to the radiance of points: shadow rays to their patches, and the BRDF.

#include "shading/bake/source_light.h"
#include "shading/scene/emitter.h"

namespace haarfield {

/// Adds to each receiver's outgoing radiance what the emitters shed on it that nothing blocks.
///
/// radiance  as many. [W/(m^2 sr)]
/// diffuse   as many, to which what the diffuse term makes of it is added, too; or none.
/// accuracy  unshadowed, 0.5 % of the diffuse part (find_patches); shadows have as many steps as there are
///           patches. Lobes are widened by what a patch spreads over.
/// cost      100 ns a patch that a receiver faces, of which there are some 20 where the emitters look small,
///           and up to EmitterCut::most beside large ones.
void add_emitter_light(const ShadowRays& rays, const EmitterTree& emitters,
                       std::span<const SourceReceiver> receivers, std::span<Rgb> radiance,
                       std::span<Rgb> diffuse = {}, const EmitterCut& cut = {});

/// For oracles: six times as many patches, each with eight times less of the power.
inline constexpr EmitterCut fine_emitter_cut{0.02f, 1.0f / 512, 4096};

}  // namespace haarfield
