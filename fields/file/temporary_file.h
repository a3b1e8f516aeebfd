#pragma once
/// Files that appear complete or not at all, even if several processes write the same file.

#include "fields/base/result.h"

#include <filesystem>
#include <string_view>

namespace haarfield {

/// An empty file next to its target, with a name that is unique among all processes and machines: the first
/// 100 bytes of the target's name, process_name, a number, `.tmp`. The destructor removes it unless it has
/// replaced the target. Threads, processes and machines may write files for one target at the same time; the
/// last one to replace it wins. No locks are used, because some network file systems grant them to everyone.
class TemporaryFile {
public:
    /// Creates a file next to the target. Symbolic links to the target are followed.
    ///
    /// errors  those of the system (no such folder, no permission ...); a directory, a device or a pipe.
    static Result<TemporaryFile> beside(const std::filesystem::path& target);

    TemporaryFile(TemporaryFile&& other) noexcept;  ///< Takes ownership of the file.
    TemporaryFile& operator=(TemporaryFile&&) = delete;
    ~TemporaryFile();

    const std::filesystem::path& target() const { return target_; }  ///< The file that it will replace.

    /// Appends bytes.
    ///
    /// errors  those of the system (full disk ...).
    Result<Done> write(std::string_view bytes);

    /// Atomically replaces the target.
    ///
    /// errors  those of the system; the target is then unchanged.
    Result<Done> take_place();

    /// Flushes the file to disk, verifies that it contains `bytes`, and replaces the target.
    ///
    /// errors  those of take_place(); the content differs from `bytes`.
    Result<Done> replace_target(std::string_view bytes);

private:
    TemporaryFile(std::filesystem::path target, std::filesystem::path file, int descriptor)
        : target_(std::move(target)), file_(std::move(file)), descriptor_(descriptor) {}

    std::filesystem::path target_, file_;
    int descriptor_;         ///< -1: moved from.
    bool in_place_ = false;  ///< True once it has replaced the target.
};

/// Removes the temporary files in a folder whose processes have ended: those of this machine at once, those
/// of other machines, whose state is unknown, after a day. Ignores files that cannot be removed.
void remove_abandoned_files(const std::filesystem::path& folder);

}  // namespace haarfield
