#include "fields/file/input_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

namespace haarfield {
namespace {

Error system_failure(const std::string& where, int number) {
    if (number == ENOENT || number == ENOTDIR) return {where, "there is no such file"};
    return {where, fmt::format("cannot be read: {}", std::strerror(number))};
}

/// Returns the type of a file that is not a regular file.
const char* type_name(mode_t mode) {
    switch (mode & S_IFMT) {
        case S_IFDIR: return "a directory";
        case S_IFIFO: return "a pipe";
        case S_IFSOCK: return "a socket";
        case S_IFCHR:
        case S_IFBLK: return "a device";
        default: return "not a regular file";
    }
}

Result<Done> check_type(const struct stat& status, const std::string& where, const std::string& expected) {
    if (S_ISREG(status.st_mode)) return Done{};
    return Error{where, fmt::format("is {}; expected {}", type_name(status.st_mode), expected)};
}

}  // namespace

Result<InputFile> InputFile::open(const std::filesystem::path& file) {
    const std::string where = file.string();
    // Checked before opening, because opening a device can have side effects. Checked again below, because
    // another file may take the name in between.
    HF_TRY_DONE(check_input_file(file));
    const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (descriptor < 0) return system_failure(where, errno);
    InputFile opened(descriptor);
    struct stat status {};
    if (fstat(descriptor, &status) != 0) return system_failure(where, errno);
    HF_TRY_DONE(check_type(status, where, "a file"));
    return opened;
}

InputFile::~InputFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
}

Result<Done> check_input_file(const std::filesystem::path& file, const std::string& expected) {
    struct stat status {};
    if (stat(file.c_str(), &status) == 0) return check_type(status, file.string(), expected);
    Error failure = system_failure(file.string(), errno);
    if (expected != "a file") failure.what += "; expected " + expected;
    return failure;
}

Result<std::string> read_whole_file(const std::filesystem::path& file, std::uint64_t most_bytes) {
    HF_TRY(const InputFile opened, InputFile::open(file));
    // The size that the system reports is 0 for files below /proc.
    std::string bytes;
    std::array<char, 65536> piece;
    while (true) {
        const ssize_t count = read(opened.descriptor(), piece.data(), piece.size());
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) return system_failure(file.string(), errno);
        if (count == 0) return bytes;
        bytes.append(piece.data(), static_cast<std::size_t>(count));
        if (bytes.size() > most_bytes)
            return Error{file.string(), fmt::format("is larger than {} MiB", most_bytes >> 20)};
    }
}

}  // namespace haarfield
