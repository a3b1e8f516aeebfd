#include "fields/temporary_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>

namespace haarfield {

TemporaryFile::TemporaryFile(const std::filesystem::path& target) : target_(target) {
    static std::atomic<unsigned> counter = 0;
    do {
        path_ = target;
        path_ += fmt::format(".{}-{}.tmp", getpid(), counter++);
        descriptor_ = open(path_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    } while (descriptor_ < 0 && errno == EEXIST);
    if (descriptor_ < 0) error_number_ = errno;
}

TemporaryFile::~TemporaryFile() {
    if (descriptor_ < 0) return;
    close(descriptor_);
    if (!path_.empty()) unlink(path_.c_str());
}

bool TemporaryFile::write_at(std::uint64_t offset, std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t written = pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) return false;
        bytes.remove_prefix(static_cast<std::size_t>(written));
        offset += static_cast<std::uint64_t>(written);
    }
    return true;
}

bool TemporaryFile::replace_target() {
    if (fsync(descriptor_) != 0 || std::rename(path_.c_str(), target_.c_str()) != 0) return false;
    path_.clear();
    // The file is whole and in place. Whether the folder's entry has reached the disk is all that is left to
    // ask for, and some file systems can not tell.
    const std::filesystem::path folder = target_.has_parent_path() ? target_.parent_path() : ".";
    if (const int entry = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); entry >= 0) {
        fsync(entry);
        close(entry);
    }
    return true;
}

}  // namespace haarfield
