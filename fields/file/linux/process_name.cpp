#include "fields/file/process_name.h"

#include "fields/file/linux/process_status.h"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>
#include <xxhash.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <fstream>
#include <iterator>

namespace haarfield {
namespace {

constexpr std::size_t place_digits = 12;

std::string text_of(const char* file) {
    std::ifstream stream(file);
    return {std::istreambuf_iterator<char>(stream), {}};
}

/// Returns a hash of the machine and its process number space, because containers on a machine may use the
/// same numbers.
std::string this_place() {
    std::array<char, 256> host{}, numbers{};
    gethostname(host.data(), host.size() - 1);
    (void)!readlink("/proc/self/ns/pid", numbers.data(), numbers.size() - 1);
    const std::string all =
        std::string(host.data()) + '\n' + text_of("/proc/sys/kernel/random/boot_id") + numbers.data();
    return fmt::format("{:016x}", XXH3_64bits(all.data(), all.size())).substr(0, place_digits);
}

/// Returns the start time of a process, in the system's unit; 0 if unknown.
std::uint64_t start_of(pid_t process) {
    const std::vector<std::string> status = process_status(process);
    constexpr std::size_t start_word = 19;
    std::uint64_t start = 0;
    if (status.size() > start_word)
        std::from_chars(status[start_word].data(), status[start_word].data() + status[start_word].size(),
                        start);
    return start;
}

/// Reads a number that is followed by the character `end`, or by the end of the text. Advances the text.
template <class T>
bool take_number(std::string_view& text, char end, T& number) {
    const auto [last, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc()) return false;
    text.remove_prefix(static_cast<std::size_t>(last - text.data()));
    if (text.empty()) return end == '\0';
    if (text.front() != end) return false;
    text.remove_prefix(1);
    return true;
}

}  // namespace

std::string process_name() {
    const pid_t process = getpid();
    return fmt::format("{}-{}-{}", this_place(), process, start_of(process));
}

Liveness process_liveness(std::string_view name) {
    const std::string place = this_place();
    if (!name.starts_with(place + "-")) return Liveness::unknown;
    name.remove_prefix(place.size() + 1);
    pid_t process = 0;
    std::uint64_t start = 0;
    if (!take_number(name, '-', process) || process <= 0 || !take_number(name, '\0', start))
        return Liveness::unknown;
    if (kill(process, 0) != 0 && errno == ESRCH) return Liveness::ended;
    const std::uint64_t its_start = start_of(process);
    return its_start == 0 || its_start == start ? Liveness::alive : Liveness::ended;
}

}  // namespace haarfield
