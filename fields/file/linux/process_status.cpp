#include "fields/file/linux/process_status.h"

#include <fstream>
#include <iterator>
#include <sstream>

namespace haarfield {

std::vector<std::string> process_status(pid_t process) {
    std::ifstream stream("/proc/" + std::to_string(process) + "/stat");
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    const std::size_t name_end = text.rfind(')');  // a process's name may contain anything
    if (name_end == std::string::npos) return {};
    std::istringstream words(text.substr(name_end + 1));
    return {std::istream_iterator<std::string>(words), {}};
}

}  // namespace haarfield
