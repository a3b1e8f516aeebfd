#include "fields/file/linux/process_status.h"

#include <iterator>
#include <sstream>

#include "fields/file/input_file.h"

namespace haarfield {

std::vector<std::string> process_status(pid_t process) {
    const Result<std::string> read =
        read_whole_file("/proc/" + std::to_string(process) + "/stat", std::uint64_t{1} << 20);
    const std::string text = read ? *read : std::string();
    const std::size_t name_end = text.rfind(')');  // a process's name may contain anything
    if (name_end == std::string::npos) return {};
    std::istringstream words(text.substr(name_end + 1));
    return {std::istream_iterator<std::string>(words), {}};
}

}  // namespace haarfield
