#pragma once
/// Estimates the number of lights that a reference needs.

#include "bridge/povray/reference_picture.h"
#include "bridge/povray/reference_scene.h"

namespace haarfield {

/// Returns the number of lights for a required relative error, estimated from small pictures with up to 1,024
/// lights.
///
/// folder, stem  where the scenes of the small pictures are written; the last one remains.
/// options       those of the full picture.
/// returns       an error above the required one only if most_reference_lights are too few.
/// cost          up to six pictures with a quarter of the width and height.
/// errors        as write_reference_scene and run_povray.
Result<LightEstimate> lights_for_error(const std::filesystem::path& folder, const std::string& stem,
                                       const Camera& camera, std::span<const ReferenceInstance> instances,
                                       const Environment& environment, std::span<const Lamp> lamps,
                                       const PovrayOptions& options, double wanted,
                                       const Progress& progress = {});

}  // namespace haarfield
