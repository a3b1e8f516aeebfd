#pragma once
/// Parallel loops on oneTBB with progress reports and cancellation.

#include "fields/base/progress.h"
#include "fields/base/result.h"

#include <cstddef>
#include <functional>
#include <string_view>

namespace haarfield {

/// Processes one item of a loop.
using LoopBody = std::function<void(std::size_t item)>;

/// The items of a loop, and how many of them form one task.
struct LoopItems {
    std::size_t count = 0;
    std::size_t together = 1;  ///< Consecutive items that one thread processes in order. >= 1.
};

/// Processes the items 0 ... count - 1, each once.
///
/// make_body  makes the body of one thread, with that thread's buffers. The result of an item must depend on
///            the item only, so that results do not depend on the number of threads. Bodies and reports may
///            run parallel algorithms: no body is entered again before it has returned.
/// stage      the name passed to `progress.report`, with the number of finished items. Reports never overlap.
/// cost       a few nanoseconds per item, and one lock per `together` items if progress is reported.
/// errors     interrupted, once the current items are finished.
Result<Done> parallel_loop(const LoopItems& items, const std::function<LoopBody()>& make_body,
                           std::string_view stage, const Progress& progress);

/// Returns a Progress for a loop whose items each stand for `together` smaller ones, `count` of these in all.
/// It converts counts to smaller items. `progress` must outlive the result.
Progress counted_by(std::size_t together, std::size_t count, const Progress& progress);

}  // namespace haarfield
