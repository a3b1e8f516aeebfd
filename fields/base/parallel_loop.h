#pragma once
/// A loop on all of oneTBB's threads that tells how far it is, and can be stopped.

#include "fields/base/progress.h"
#include "fields/base/result.h"

#include <cstddef>
#include <functional>
#include <string_view>

namespace haarfield {

/// Does one item of a loop.
using LoopBody = std::function<void(std::size_t item)>;

/// How a loop is shared out among threads.
struct LoopItems {
    std::size_t count = 0;
    std::size_t together = 1;  ///< So many neighbours are done by one thread, one after the other. >= 1.
};

/// Does the items 0 ... count - 1, each once.
///
/// make_body  makes the body for one thread, with that thread's buffers. What a body does with an item may
///            depend on nothing but the item, so that the number of threads changes nothing. Bodies and
///            reports may run parallel algorithms: no body is entered again before it has returned.
/// stage      what progress is told, with the number of items that are done; never from two threads at once.
/// cost       a few nanoseconds an item, and a lock for each `together` of them where progress is reported.
/// errors     interrupted: as soon as the items at hand are done.
Result<Done> parallel_loop(const LoopItems& items, const std::function<LoopBody()>& make_body,
                           std::string_view stage, const Progress& progress);

/// What to pass on where an item of a loop is a run of smaller ones: reports these, `together` an item and
/// `count` in all. The progress must outlive the result.
Progress counted_by(std::size_t together, std::size_t count, const Progress& progress);

}  // namespace haarfield
