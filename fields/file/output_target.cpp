#include "fields/file/output_target.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <optional>

#include "fields/file/mapped_file.h"

namespace haarfield {
namespace {

using std::filesystem::path;

constexpr int most_links = 40;  // the limit of Linux

Error system_error(const path& file, const char* action, int number) {
    return {file.string(), fmt::format("cannot {}: {}", action, std::strerror(number))};
}

bool is_same_file(const struct stat& a, const struct stat& b) {
    return a.st_dev == b.st_dev && a.st_ino == b.st_ino;
}

/// Returns the standard stream that writes to the file, such as /dev/stdout if output is redirected to a
/// file.
std::optional<int> standard_stream(const struct stat& file) {
    for (const int stream : {STDOUT_FILENO, STDERR_FILENO}) {
        struct stat status {};
        if (fstat(stream, &status) == 0 && is_same_file(status, file)) return stream;
    }
    return std::nullopt;
}

}  // namespace

Result<OutputTarget> output_target(const path& file) {
    struct stat status {};
    if (stat(file.c_str(), &status) == 0) {
        if (S_ISDIR(status.st_mode))
            return Error{file.string(), "is a directory; expected the name of a file"};
        if (!S_ISREG(status.st_mode) || standard_stream(status)) return OutputTarget{file, true};
    } else if (errno == ELOOP) {
        return system_error(file, "follow its symbolic links", ELOOP);
    }
    path target = file;
    for (int links = 0; links < most_links; ++links) {
        std::error_code no_link;
        const path next = std::filesystem::read_symlink(target, no_link);
        if (no_link) return OutputTarget{target, false};
        target = target.parent_path() / next;
    }
    return system_error(file, "follow its symbolic links", ELOOP);
}

Result<Done> write_stream(const OutputTarget& stream, std::string_view bytes) {
    struct stat status {};
    const std::optional<int> standard =
        stat(stream.file.c_str(), &status) == 0 ? standard_stream(status) : std::nullopt;
    const int descriptor = standard ? fcntl(*standard, F_DUPFD_CLOEXEC, 0)
                                    : open(stream.file.c_str(), O_WRONLY | O_NOCTTY | O_CLOEXEC);
    if (descriptor < 0) return system_error(stream.file, "open it", errno);
    int failure = 0;
    while (!bytes.empty() && failure == 0) {
        const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
        if (written > 0)
            bytes.remove_prefix(static_cast<std::size_t>(written));
        else if (written == 0 || errno != EINTR)
            failure = written < 0 ? errno : ENOSPC;
    }
    if (close(descriptor) != 0 && failure == 0) failure = errno;
    if (failure != 0) return system_error(stream.file, "write it", failure);
    return Done{};
}

Result<Done> move_output(const path& made, const OutputTarget& target) {
    if (!target.is_stream) {
        if (std::rename(made.c_str(), target.file.c_str()) != 0)
            return system_error(target.file, "replace it", errno);
        return Done{};
    }
    Result<Done> written = Done{};
    {
        const Result<MappedFile> bytes = mapped_file(made);
        written = bytes ? write_stream(target, bytes->bytes) : bytes.error();
    }
    unlink(made.c_str());
    return written;
}

}  // namespace haarfield
