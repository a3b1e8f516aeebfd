#include "fields/base/parallel_loop.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <mutex>

namespace haarfield {

Result<Done> parallel_loop(const LoopItems& items, const std::function<LoopBody()>& make_body,
                           std::string_view stage, const Progress& progress) {
    tbb::enumerable_thread_specific<LoopBody> bodies(make_body);
    std::mutex progress_mutex;
    std::uint64_t done = 0;
    const std::size_t parts = (items.count + items.together - 1) / items.together;
    const auto do_part = [&](std::size_t part) {
        const LoopBody& body = bodies.local();
        const std::size_t first = part * items.together, end = std::min(items.count, first + items.together);
        for (std::size_t item = first; item < end; ++item) {
            if (progress.stop.stop_requested()) return;
            body(item);
        }
        if (!progress.report) return;
        const std::lock_guard lock(progress_mutex);
        done += end - first;
        progress.report(stage, done, items.count);
    };
    tbb::parallel_for(std::size_t(0), parts, [&](std::size_t part) {
        // A thread that waits for nested parallel work must not start another part: the body's buffers are in
        // use, and the lock may be held.
        tbb::this_task_arena::isolate([&] { do_part(part); });
    });
    if (progress.stop.stop_requested()) return interruption();
    return Done{};
}

Progress counted_by(std::size_t together, std::size_t count, const Progress& progress) {
    Progress result{{}, progress.stop};
    if (progress.report)
        result.report = [together, count, &progress](std::string_view stage, std::uint64_t done,
                                                     std::uint64_t) {
            progress.report(stage, std::min<std::uint64_t>(done * together, count), count);
        };
    return result;
}

}  // namespace haarfield
