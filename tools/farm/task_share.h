#pragma once
/// What a command does of a job that is divided: some of its parts, or joining them all.

#include "bridge/povray/reference_picture.h"
#include "fields/file/section_file.h"
#include "shading/scene/shared_shading.h"

#include <string>
#include <utility>
#include <vector>

namespace haarfield {

/// Items from the first up to, but not including, the second.
using ItemRange = std::pair<std::size_t, std::size_t>;

/// The items of consecutive parts of a job.
inline ItemRange items_of_parts(std::size_t items, std::size_t first, std::size_t count, std::size_t parts) {
    return {items * first / parts, items * (first + count) / parts};
}

/// Commands find it in their context: null where they do everything.
struct TaskShare {
    std::size_t part = 0, count = 1, parts = 1;  ///< Consecutive parts, made together; all parts of the job.
    bool joins = false;                          ///< All parts are there; else these are to be made.
    std::vector<std::vector<Section>> made;      ///< By part, from `part` on: `count` of them.
    std::vector<std::vector<Section>> joined;  ///< By part; points of one without sections are shaded again.

    TaskShare() = default;
    TaskShare(std::size_t first, std::size_t count_of_these, std::size_t of_all)
        : part(first), count(count_of_these), parts(of_all), made(count_of_these) {}

    ItemRange range(std::size_t items) const { return items_of_parts(items, part, count, parts); }
    /// The items of the k-th of these parts.
    ItemRange range_of(std::size_t k, std::size_t items) const {
        return items_of_parts(items, part + k, 1, parts);
    }
};

/// The folder below a command's output in which it writes the files of the share's k-th part.
std::string part_folder(std::size_t k);

/// Divides loops over points: the points of the share's parts are shaded together and stored in `made`, or
/// all points are read from `joined`. The share must outlive the result.
PointSharing point_sharing(TaskShare& share);

/// Strips are of so many rows: POV-Ray's blocks, by which it decides where it takes more rays.
inline constexpr int strip_unit = 32;

/// How many parts a reference of so many rows can have: for each set of lights as many strips.
std::size_t most_reference_parts(int height);

/// Renders the strips of the parts into `made`, those of one set of lights together; or reads all from
/// `joined`.
///
/// returns  as rendered_reference has it; without a picture where only strips were rendered.
Result<ReferencePicture> shared_reference(const ReferenceFiles& scene, const PovrayOptions& options,
                                          const Progress& progress, TaskShare& share);

}  // namespace haarfield
