#include "fields/file/temporary_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <thread>
#include <utility>

#include "fields/file/mapped_file.h"

namespace haarfield {
namespace {

using std::filesystem::path;

constexpr const char* ending = ".tmp";

path temporary_path(const path& target) {
    path temporary = target;
    temporary += ending;
    return temporary;
}

Error system_error(const path& file, const char* action, int number) {
    return {file.string(), fmt::format("cannot {}: {}", action, std::strerror(number))};
}

/// Whether a descriptor is still what the path names: the file may have been renamed or removed meanwhile.
bool is_at(int descriptor, const path& file) {
    struct stat held {
    }, named{};
    return fstat(descriptor, &held) == 0 && stat(file.c_str(), &named) == 0 && held.st_dev == named.st_dev &&
           held.st_ino == named.st_ino;
}

/// Locks a file, or tells at once that another one holds it (EWOULDBLOCK).
bool try_lock(int descriptor) {
    int locked = -1;
    do locked = flock(descriptor, LOCK_EX | LOCK_NB);
    while (locked != 0 && errno == EINTR);
    return locked == 0;
}

}  // namespace

Result<TemporaryFile> TemporaryFile::beside(const path& target, const Progress& progress) {
    const path temporary = temporary_path(target);
    while (true) {
        const int descriptor = open(temporary.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
        if (descriptor < 0) return system_error(target, "make a file beside it", errno);
        const bool locked = try_lock(descriptor);
        const int number = errno;
        if (locked && is_at(descriptor, temporary) && ftruncate(descriptor, 0) == 0)
            return TemporaryFile(target, descriptor);
        close(descriptor);
        if (!locked && number != EWOULDBLOCK) return system_error(target, "lock the file beside it", number);
        if (progress.stop.stop_requested()) return Error{target.string(), interrupted};
        if (locked) continue;
        if (progress.report)
            progress.report("waiting for another process that makes " + target.filename().string(), 0, 1);
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
}

TemporaryFile::TemporaryFile(TemporaryFile&& other) noexcept
    : target_(std::move(other.target_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      in_place_(other.in_place_) {}

TemporaryFile::~TemporaryFile() {
    if (descriptor_ < 0) return;
    if (!in_place_) unlink(temporary_path(target_).c_str());
    close(descriptor_);  // last: it lets go of the lock
}

Result<Done> TemporaryFile::write(std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) return system_error(target_, "write it", written < 0 ? errno : ENOSPC);
        bytes.remove_prefix(static_cast<std::size_t>(written));
    }
    return Done{};
}

Result<Done> TemporaryFile::take_place() {
    if (std::rename(temporary_path(target_).c_str(), target_.c_str()) != 0)
        return system_error(target_, "put it in its place", errno);
    in_place_ = true;
    return Done{};
}

Result<Done> TemporaryFile::replace_target(std::string_view bytes) {
    if (fsync(descriptor_) != 0) return system_error(target_, "bring it to the disk", errno);
    {
        const Result<MappedFile> written = mapped_file(temporary_path(target_));
        if (!written) return written.error();
        if (written->bytes != bytes) return Error{target_.string(), "reads back otherwise than written"};
    }
    if (Result<Done> placed = take_place(); !placed) return placed;
    // The file is whole and in place. Whether the folder's entry has reached the disk is all that is left to
    // ask for, and some file systems can not tell.
    const path folder = target_.has_parent_path() ? target_.parent_path() : ".";
    if (const int entry = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); entry >= 0) {
        fsync(entry);
        close(entry);
    }
    return Done{};
}

void remove_abandoned_files(const path& folder) {
    std::error_code failed;
    for (std::filesystem::directory_iterator entry(folder, failed), end; !failed && entry != end;
         entry.increment(failed)) {
        const path& file = entry->path();
        if (file.extension() != ending) continue;
        const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
        if (descriptor < 0) continue;
        if (try_lock(descriptor) && is_at(descriptor, file)) unlink(file.c_str());
        close(descriptor);
    }
}

}  // namespace haarfield
