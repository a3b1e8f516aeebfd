#pragma once
/// Restrictions of child processes that run untrusted input.

#include "fields/base/result.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace haarfield {

/// The files and resources that a child process may use.
struct ChildLimits {
    std::vector<std::filesystem::path> readable;        ///< Folders and files, for reading and execution.
    std::vector<std::filesystem::path> writable;        ///< Folders, for reading and writing.
    std::uint64_t memory = std::uint64_t{4} << 30;      ///< Address space. [bytes]
    std::uint64_t file_bytes = std::uint64_t{1} << 30;  ///< Of each written file. [bytes]
    double processor_seconds = 600;                     ///< Processor time of all its threads. [s]
};

/// The restrictions of one child process: its files by Landlock, its resources by limits. The network is
/// closed if the kernel's Landlock can do so (version 4). ChildProcess::start applies them before the program
/// runs.
class ChildSandbox {
public:
    /// Prepares a sandbox. Paths that do not exist are left out.
    ///
    /// with_files  false: only the resources are limited, because the program restricts files by itself.
    /// errors      the system has no Landlock.
    static Result<ChildSandbox> create(const ChildLimits& limits, bool with_files = true);

    ChildSandbox(ChildSandbox&& other) noexcept;  ///< Takes ownership.
    ChildSandbox& operator=(ChildSandbox&&) = delete;
    ~ChildSandbox();

    /// Restricts this process permanently. Safe between fork and exec. Returns false if the system refuses.
    bool enter() const;

private:
    ChildSandbox(const ChildLimits& limits, int rules) : limits_(limits), rules_(rules) {}

    ChildLimits limits_;
    int rules_ = -1;  ///< A Landlock rule set; -1: none.
};

}  // namespace haarfield
