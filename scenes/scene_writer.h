#pragma once
/// Writes scene files.

#include "fields/base/result.h"
#include "scenes/scene.h"

#include <string_view>

namespace haarfield {

/// Returns a scene file from which read_scene restores the scene, up to rounding of shapes and of angles to
/// degrees. Materials of the povray convention are written as `pigment` and `finish` where these can express
/// them.
///
/// folder    the directory of the file. Paths are written relative to it if that takes at most three steps
///           up, else absolute.
/// comments  lines written at the top, without `#`; may be empty.
std::string scene_text(const Scene& scene, const std::filesystem::path& folder,
                       std::string_view comments = {});

}  // namespace haarfield
