#include "fields/file/linux/process_status.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <sstream>

namespace haarfield {

namespace {

/// Returns the beginning of a file; empty if it cannot be read. A stream would throw if the process ends
/// before it is read.
std::string beginning_of(const std::string& file) {
    const int opened = open(file.c_str(), O_RDONLY | O_CLOEXEC);
    if (opened < 0) return {};
    std::array<char, 4096> bytes;
    const ssize_t count = read(opened, bytes.data(), bytes.size());
    close(opened);
    return {bytes.data(), static_cast<std::size_t>(std::max<ssize_t>(0, count))};
}

}  // namespace

std::vector<std::string> process_status(pid_t process) {
    const std::string text = beginning_of("/proc/" + std::to_string(process) + "/stat");
    const std::size_t name_end = text.rfind(')');  // a process's name may contain anything
    if (name_end == std::string::npos) return {};
    std::istringstream words(text.substr(name_end + 1));
    return {std::istream_iterator<std::string>(words), {}};
}

}  // namespace haarfield
