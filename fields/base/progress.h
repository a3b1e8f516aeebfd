#pragma once
/// Progress reports and cancellation of long computations.

#include "fields/base/result.h"

#include <cstdint>
#include <functional>
#include <stop_token>
#include <string_view>

namespace haarfield {

/// The progress and cancellation interface of every function that may run longer than a second. Both members
/// may be empty.
struct Progress {
    /// Called with the name of the stage and the number of finished items. Calls may come from any thread,
    /// but never overlap. The callee must be cheap.
    std::function<void(std::string_view stage, std::uint64_t done, std::uint64_t total)> report;

    /// After a stop request, the computation returns within about 50 ms with the error
    /// `ErrorCode::interrupted` and leaves nothing half-written.
    std::stop_token stop;
};

/// Returns the error of a computation that stopped on request.
///
/// where  the file or entity concerned; may be empty.
inline Error interruption(std::string where = {}) {
    return {std::move(where), "interrupted", ErrorCode::interrupted};
}

}  // namespace haarfield
