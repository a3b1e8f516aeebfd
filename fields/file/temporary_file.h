#pragma once
/// Files that appear whole or not at all, made by one process at a time.

#include "fields/base/progress.h"
#include "fields/base/result.h"

#include <cstdint>
#include <filesystem>
#include <string_view>

namespace haarfield {

/// An empty file beside a target, with `.tmp` after its name; removed with this object unless it took the
/// target's place. While it lives, no other thread or process has one for the same target (flock). What a
/// killed process left there is emptied and used.
class TemporaryFile {
public:
    /// Waits while another thread or process makes the target.
    ///
    /// errors  what the system says (no such folder, no right to write ...); `interrupted`.
    static Result<TemporaryFile> beside(const std::filesystem::path& target, const Progress& progress = {});

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
    TemporaryFile(std::filesystem::path target, int descriptor)
        : target_(std::move(target)), descriptor_(descriptor) {}

    std::filesystem::path target_;
    int descriptor_;         ///< -1: moved from.
    bool in_place_ = false;  ///< Took the target's place.
};

/// Removes the temporary files in a folder that no living process holds. What cannot be removed stays.
void remove_abandoned_files(const std::filesystem::path& folder);

}  // namespace haarfield
