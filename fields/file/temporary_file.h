#pragma once
/// Files that appear whole or not at all, whoever else makes the same ones.

#include "fields/base/result.h"

#include <filesystem>
#include <string_view>

namespace haarfield {

/// An empty file beside a target, of a name that no other process has, on whatever machine: the target's (its
/// first 100 bytes), process_name, a number, `.tmp`. Removed with this object unless it took the target's
/// place. Several may be made for one target at once, by threads, processes and machines: the last one that
/// takes the place stays. Nothing rests on locks, which some network file systems grant to everybody.
class TemporaryFile {
public:
    /// Symbolic links to the target are followed.
    ///
    /// errors  those of the system (no such folder, no right to write ...); a directory, a device or a pipe.
    static Result<TemporaryFile> beside(const std::filesystem::path& target);

    TemporaryFile(TemporaryFile&& other) noexcept;  ///< Takes the file over.
    TemporaryFile& operator=(TemporaryFile&&) = delete;
    ~TemporaryFile();

    const std::filesystem::path& target() const { return target_; }  ///< The file that it is to become.

    /// Appends.
    ///
    /// errors  what the system says (full disk ...).
    Result<Done> write(std::string_view bytes);

    /// Takes the target's place, in one step.
    ///
    /// errors  what the system says; the target is then as it was.
    Result<Done> take_place();

    /// The same once the content is on disk, and equal to `bytes`.
    ///
    /// errors  as above; content that is not `bytes`.
    Result<Done> replace_target(std::string_view bytes);

private:
    TemporaryFile(std::filesystem::path target, std::filesystem::path file, int descriptor)
        : target_(std::move(target)), file_(std::move(file)), descriptor_(descriptor) {}

    std::filesystem::path target_, file_;
    int descriptor_;         ///< -1: moved from.
    bool in_place_ = false;  ///< Took the target's place.
};

/// Removes the temporary files in a folder whose processes have ended: this machine's at once, those of other
/// machines, of which that can not be known, after a day. What cannot be removed stays.
void remove_abandoned_files(const std::filesystem::path& folder);

}  // namespace haarfield
