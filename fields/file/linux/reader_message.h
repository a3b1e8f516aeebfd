#pragma once
/// Messages between a reader process and its clients. Internal.

#include <array>
#include <cstdint>

namespace haarfield {

/// Exit codes of workers. Libraries and sanitizers do not use these codes.
enum class WorkerExit : int {
    done = 40,         ///< The answer is the output of the task.
    refused = 41,      ///< The answer is an error message about the file.
    unsandboxed = 42,  ///< The sandbox could not be set up; the file was not read.
};

/// A request to the reader process, sent before the details, with the descriptors of file, answer and
/// outcome.
struct ReaderRequest {
    std::array<char, 16> task{};  ///< The name of the task, padded with zeros.
    std::uint64_t memory = 0;     ///< ReaderLimits::memory
    std::uint64_t answer = 0;     ///< ReaderLimits::answer
    double seconds = 0;           ///< ReaderLimits::seconds
    std::int64_t may_be_unsandboxed = 0;
};
inline constexpr std::size_t longest_details = 16384;  ///< [bytes]

/// The reply of the reader process after a worker has ended.
struct ReaderOutcome {
    std::int32_t status = 0;   ///< Status of waitpid; -1: no worker could be started.
    std::int32_t stalled = 0;  ///< 1 if it was killed because all its threads slept for a long time.
};

}  // namespace haarfield
