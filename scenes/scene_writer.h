#pragma once
/// Scene files out.

#include "fields/base/result.h"
#include "scenes/scene.h"

#include <string_view>

namespace haarfield {

/// A scene as read_scene takes it: it gives the scene back, up to the rounding of angles to floats in degrees
/// and of shapes; materials of the povray convention become `pigment` and `finish` where these can say them.
///
/// folder    where the file will be: paths are written relative to it where they lie below or beside, else
///           absolute.
/// comments  lines that are put on top, without `#`; may be empty.
std::string scene_text(const Scene& scene, const std::filesystem::path& folder,
                       std::string_view comments = {});

}  // namespace haarfield
