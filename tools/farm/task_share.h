#pragma once
/// The share of a divided job that a command runs: some of its parts, or the join of all parts.

#include "bridge/povray/reference_picture.h"
#include "fields/file/section_file.h"
#include "shading/scene/shared_shading.h"

#include <string>
#include <utility>
#include <vector>

namespace haarfield {

/// Items from the first up to but excluding the second.
using ItemRange = std::pair<std::size_t, std::size_t>;

/// Returns the items of consecutive parts of a job.
inline ItemRange items_of_parts(std::size_t items, std::size_t first, std::size_t count, std::size_t parts) {
    return {items * first / parts, items * (first + count) / parts};
}

/// A command's share of a job. CommandContext::share points to it, or is null for an undivided command.
struct TaskShare {
    /// The first of `count` consecutive parts; the number of all parts.
    std::size_t part = 0, count = 1, parts = 1;
    bool joins = false;  ///< True: all parts are computed. False: these parts are to be computed.
    std::vector<std::vector<Section>> made;  ///< Results of the `count` parts from `part` on.
    /// By part. Points of a part without sections are shaded again.
    std::vector<std::vector<Section>> joined;

    TaskShare() = default;
    TaskShare(std::size_t first, std::size_t count_of_these, std::size_t of_all)
        : part(first), count(count_of_these), parts(of_all), made(count_of_these) {}

    ItemRange range(std::size_t items) const { return items_of_parts(items, part, count, parts); }
    /// Returns the items of the k-th of these parts.
    ItemRange range_of(std::size_t k, std::size_t items) const {
        return items_of_parts(items, part + k, 1, parts);
    }
};

/// Returns the folder below a command's output for the files of the share's k-th part.
std::string part_folder(std::size_t k);

/// Divides loops over points: shades the points of the share's parts together and stores them in `made`, or
/// reads all points from `joined`. The share must outlive the result.
PointSharing point_sharing(TaskShare& share);

/// Rows per strip: POV-Ray decides by blocks of 32 rows which pixels get more rays.
inline constexpr int strip_unit = 32;

/// Returns the largest number of parts of a reference with `height` rows: both sets of lights times the
/// number of strips.
std::size_t most_reference_parts(int height);

/// Renders the strips of the parts into `made`, those of one set of lights together; or reads all strips from
/// `joined`.
///
/// returns  as rendered_reference; without a picture if only strips were rendered.
Result<ReferencePicture> shared_reference(const ReferenceFiles& scene, const PovrayOptions& options,
                                          const Progress& progress, TaskShare& share);

}  // namespace haarfield
