#pragma once
/// How a long computation tells how far it is, and learns that it should stop.

#include <cstdint>
#include <functional>
#include <stop_token>
#include <string_view>

namespace haarfield {

/// Passed to everything that may last longer than a second. Both members may be left empty.
struct Progress {
    /// Called with the name of the stage and the items done of a total. It may be called from any
    /// thread, but never from two at once, and must be cheap.
    std::function<void(std::string_view stage, std::uint64_t done, std::uint64_t total)> report;

    /// When a stop is requested the computation returns soon (within some 50 ms) with the error
    /// `interrupted`, leaving nothing half-written.
    std::stop_token stop;
};

/// The `what` of the error with which an interrupted computation returns.
inline constexpr const char* interrupted = "interrupted";

}  // namespace haarfield
