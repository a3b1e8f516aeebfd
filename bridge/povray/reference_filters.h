#pragma once
/// Writes a scene's filters for POV-Ray.

#include "fields/base/result.h"
#include "scenes/scene.h"

#include <span>

namespace haarfield {

/// Writes transparent objects that cast coloured shadows, but are not visible themselves.
///
/// name         of the scene; the files are `NAME_filter_<k>.inc`.
/// world_scale  POV-Ray units per metre.
/// includes     receives the files.
/// returns      the statements that include and place the objects.
/// errors       those of read_filter and check_povray_mesh; of the file system.
Result<std::string> write_reference_filters(const std::filesystem::path& folder, const std::string& name,
                                            std::span<const SceneFilter> filters, double world_scale,
                                            std::vector<std::filesystem::path>& includes);

}  // namespace haarfield
