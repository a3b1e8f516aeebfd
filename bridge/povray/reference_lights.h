#pragma once
/// How many lights a reference needs.

#include "bridge/povray/reference_picture.h"
#include "bridge/povray/reference_scene.h"

namespace haarfield {

/// The number of lights that a wanted relative error needs, from small pictures with up to 1,024 lights.
///
/// folder, stem  where the scenes of these pictures are written; the last one stays.
/// options       of the full picture.
/// returns       with an error above the wanted one only if most_reference_lights do not do.
/// cost          up to six pictures of a quarter of the width and height.
/// errors        as write_reference_scene and run_povray.
Result<LightEstimate> lights_for_error(const std::filesystem::path& folder, const std::string& stem,
                                       const Camera& camera, std::span<const ReferenceInstance> instances,
                                       const Environment& environment, std::span<const Lamp> lamps,
                                       const PovrayOptions& options, double wanted,
                                       const Progress& progress = {});

}  // namespace haarfield
