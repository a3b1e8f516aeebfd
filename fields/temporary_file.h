#pragma once
/// Files that appear whole or not at all.

#include <cstdint>
#include <filesystem>
#include <string_view>

namespace haarfield {

/// A new, empty file in the folder of a target; removed with this object unless it took the target's place.
///
/// Where a function returns false, errno holds the system's reason.
class TemporaryFile {
public:
    explicit TemporaryFile(const std::filesystem::path& target);
    ~TemporaryFile();
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;

    /// Whether it could be made; if not, errno at that time.
    bool exists() const { return descriptor_ >= 0; }
    int error_number() const { return error_number_; }

    const std::filesystem::path& path() const { return path_; }

    /// Overwrites or appends.
    bool write_at(std::uint64_t offset, std::string_view bytes);

    /// Waits until the content is on disk, then replaces the target in one step. On failure the target is as
    /// it was.
    bool replace_target();

private:
    std::filesystem::path target_, path_;
    int descriptor_ = -1, error_number_ = 0;
};

}  // namespace haarfield
