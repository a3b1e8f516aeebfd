#include "fields/file/process_name.h"

#include <fmt/format.h>

#include <cstdint>
#include <random>

namespace haarfield {

std::string process_name() {
    // 128 random bits: nothing here is known of machines and of the numbers of their processes.
    static const std::string name = [] {
        std::random_device random;
        const auto word = [&random] { return std::uint64_t(random()) << 32 | random(); };
        const std::uint64_t place = word(), process = word();
        return fmt::format("{:012x}-{}-0", place >> 16, process);
    }();
    return name;
}

Liveness process_liveness(std::string_view name) {
    return name == process_name() ? Liveness::alive : Liveness::unknown;
}

}  // namespace haarfield
