#pragma once
/// Points of a scene's surfaces that are no vertices, and going through many of them.

#include "shading/scene/vertex_loop.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <memory>
#include <mutex>
#include <optional>

namespace haarfield {

/// A point of an instance's fine mesh: the corners of the triangle weigh 1 - u - v, u and v.
struct MeshPoint {
    std::uint32_t instance = 0, triangle = 0;
    float u = 0, v = 0;

    std::array<float, 3> weights() const { return {1 - u - v, u, v}; }  ///< Of the triangle's corners.
};

/// The point with its normal, interpolated, and the place that it looks from, right above it. Nothing if the
/// triangle is buried in another piece of the entity, or one of its corners is.
std::optional<SurfacePoint> surface_point(const ShadedEntity& entity, const MeshPoint& point);

/// Calls body(worker, k) for each k below count, on all of oneTBB's threads.
///
/// make_worker  makes what one thread works with.
/// errors       interrupted.
template <class Worker, class Body>
Result<Done> for_each_point(std::size_t count, std::string_view stage, const Progress& progress,
                            const std::function<std::unique_ptr<Worker>()>& make_worker, const Body& body) {
    tbb::enumerable_thread_specific<std::unique_ptr<Worker>> workers(make_worker);
    std::mutex progress_mutex;
    std::uint64_t done = 0;
    tbb::parallel_for(std::size_t(0), count, [&](std::size_t k) {
        if (progress.stop.stop_requested()) return;
        body(*workers.local(), k);
        if (!progress.report) return;
        const std::lock_guard lock(progress_mutex);
        progress.report(stage, ++done, count);
    });
    if (progress.stop.stop_requested()) return Error{"", interrupted};
    return Done{};
}

}  // namespace haarfield
