#pragma once
/// The oracle: the same radiance by plain sums over the texels, with nothing approximated but the texels.

#include "shading/renderer.h"

namespace haarfield {

/// As vertex_radiance, but: every occluder, the vertex's own entity included, is rasterized at the vertex;
/// lobes are evaluated at the texels; the lighting is not truncated; sums are in double.
/// cost  some milliseconds per vertex.
Result<std::vector<std::vector<Rgb>>> dense_vertex_radiance(const ShadedScene& scene,
                                                            const RenderSettings& settings,
                                                            const Progress& progress = {});

}  // namespace haarfield
