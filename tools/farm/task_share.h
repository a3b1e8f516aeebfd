#pragma once
/// What a command does where it is done in parts: the share of one task, or putting all shares together.

#include "bridge/reference_picture.h"
#include "fields/file/section_file.h"
#include "shading/scene/shared_shading.h"

#include <string>
#include <utility>
#include <vector>

namespace haarfield {

/// Commands find it in their context: null where they do everything.
struct TaskShare {
    std::size_t part = 0, parts = 1;
    bool joins = false;                        ///< All parts are there; else this one is to be made.
    std::vector<Section> made;                 ///< By this task.
    std::vector<std::vector<Section>> joined;  ///< By part; points of one without sections are shaded anew.

    /// This part's of so many items: from the first up to, but not at, the second.
    std::pair<std::size_t, std::size_t> range(std::size_t items) const {
        return {items * part / parts, items * (part + 1) / parts};
    }
};

/// Loops over points: the part's are shaded and go into `made`, or all are taken from `joined`. The share
/// must outlive it.
PointSharing point_sharing(TaskShare& share);

/// Strips are of so many rows: POV-Ray's blocks, by which it decides where it takes more rays.
inline constexpr int strip_unit = 32;

/// How many parts a reference of so many rows can have: for each set of lights as many strips.
std::size_t most_reference_parts(int height);

/// Renders a reference's halves: the part's strip of one, into `made`; or takes all from `joined`.
///
/// returns  as rendered_reference has it; without a picture where only a strip was rendered.
Result<ReferencePicture> shared_reference(const ReferenceFiles& scene, const PovrayOptions& options,
                                          const Progress& progress, TaskShare& share);

}  // namespace haarfield
