#pragma once
/// Cheap loops over rows.

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cstddef>

namespace haarfield {

/// Calls `act` for all numbers below a count, in parallel.
template <class Act>
void for_rows(std::size_t count, const Act& act) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 4096), [&](const auto& range) {
        for (std::size_t row = range.begin(); row != range.end(); ++row) act(row);
    });
}

}  // namespace haarfield
