#pragma once
/// Radiance of points by surfaces that emit light: shadow rays to patches of the emitters, and the BRDF.

#include "shading/bake/source_light.h"
#include "shading/scene/emitter.h"

namespace haarfield {

/// Adds the light of unoccluded emitters to the outgoing radiance of each receiver.
///
/// radiance  by receiver. [W/(m^2 sr)]
/// accuracy  unshadowed, 0.5 % of the diffuse component (find_patches); shadows have as many steps as there
///           are patches. Lobes are widened by the solid angle of a patch.
/// cost      100 ns per patch that a receiver faces: some 20 patches where the emitters look small, and up to
///           EmitterCut::most next to large ones.
void add_emitter_light(const ShadowRays& rays, const EmitterTree& emitters,
                       std::span<const ShadingPoint> receivers, std::span<Outgoing> radiance,
                       const EmitterCut& cut = {});

/// For oracles: six times as many patches, each with an eighth of the power.
inline constexpr EmitterCut fine_emitter_cut{0.02f, 1.0f / 512, 4096};

}  // namespace haarfield
