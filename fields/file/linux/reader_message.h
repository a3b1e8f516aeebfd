#pragma once
/// What a reader process and those who ask it say to each other. Not for users.

#include <array>
#include <cstdint>

namespace haarfield {

/// How a worker ends whose words count. Neither is what libraries or sanitizers end a process with.
enum class WorkerExit : int {
    done = 40,         ///< The answer is what the task wrote.
    refused = 41,      ///< The answer is what is wrong with the file.
    unsandboxed = 42,  ///< The sandbox could not be set up; the file was not read.
};

/// To the reader process: before the details, with the descriptors of file, answer and outcome.
struct ReaderRequest {
    std::array<char, 16> task{};  ///< Its name, with zeros behind it.
    std::uint64_t memory = 0;     ///< ReaderLimits::memory
    std::uint64_t answer = 0;     ///< ReaderLimits::answer
    double seconds = 0;           ///< ReaderLimits::seconds
    std::int64_t may_be_unsandboxed = 0;
};
inline constexpr std::size_t longest_details = 16384;  ///< [bytes]

/// From it, once a worker has ended.
struct ReaderOutcome {
    std::int32_t status = 0;   ///< As waitpid has it; -1: it could not be started.
    std::int32_t stalled = 0;  ///< Ended because all its threads slept for a long time.
};

}  // namespace haarfield
