#include "fields/file/temporary_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <utility>

#include "fields/file/mapped_file.h"
#include "fields/file/output_target.h"
#include "fields/file/process_name.h"

namespace haarfield {
namespace {

using std::filesystem::path;

constexpr std::string_view ending = ".tmp";

path temporary_path(const path& target) {
    static std::atomic<unsigned> count = 0;
    // bytes of the target's name, so that the result does not exceed the limit for names
    constexpr std::size_t kept = 100;
    const std::string name = target.filename().string().substr(0, kept);
    return target.parent_path() / fmt::format("{}.{}.{}{}", name, process_name(), count++, ending);
}

/// Returns the process in the name of a temporary file; empty for any other file.
std::string_view process_of(std::string_view file_name) {
    if (!file_name.ends_with(ending)) return {};
    file_name.remove_suffix(ending.size());
    const std::size_t number = file_name.rfind('.');
    if (number == std::string_view::npos || number == 0) return {};
    const std::size_t process = file_name.rfind('.', number - 1);
    if (process == std::string_view::npos) return {};
    return file_name.substr(process + 1, number - process - 1);
}

Error system_error(const path& file, const char* action, int number) {
    return {file.string(), fmt::format("cannot {}: {}", action, std::strerror(number))};
}

bool is_old(const path& file) {
    std::error_code failed;
    const auto written = std::filesystem::last_write_time(file, failed);
    return !failed && std::filesystem::file_time_type::clock::now() - written > std::chrono::hours(24);
}

}  // namespace

Result<TemporaryFile> TemporaryFile::beside(const path& target) {
    HF_TRY(const OutputTarget output, output_target(target));
    if (output.is_stream) return Error{target.string(), "is a device or a pipe; expected a file"};
    const path file = temporary_path(output.file);
    const int descriptor = open(file.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (descriptor < 0) return system_error(target, "create a file next to it", errno);
    return TemporaryFile(output.file, file, descriptor);
}

TemporaryFile::TemporaryFile(TemporaryFile&& other) noexcept
    : target_(std::move(other.target_)),
      file_(std::move(other.file_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      in_place_(other.in_place_) {}

TemporaryFile::~TemporaryFile() {
    if (descriptor_ < 0) return;
    if (!in_place_) unlink(file_.c_str());
    close(descriptor_);
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
    if (std::rename(file_.c_str(), target_.c_str()) != 0) return system_error(target_, "replace it", errno);
    in_place_ = true;
    return Done{};
}

Result<Done> TemporaryFile::replace_target(std::string_view bytes) {
    if (fsync(descriptor_) != 0) return system_error(target_, "flush it to disk", errno);
    {
        HF_TRY(const MappedFile written, mapped_file(file_));
        if (written.bytes != bytes) return Error{target_.string(), "reads back differently than written"};
    }
    HF_TRY_DONE(take_place());
    // The file is complete and in place. Flushing the folder's entry is best effort, because some file
    // systems do not support it.
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
        const std::string name = entry->path().filename().string();
        const std::string_view process = process_of(name);
        if (process.empty()) continue;
        const Liveness liveness = process_liveness(process);
        if (liveness == Liveness::ended || (liveness == Liveness::unknown && is_old(entry->path())))
            unlink(entry->path().c_str());
    }
}

}  // namespace haarfield
