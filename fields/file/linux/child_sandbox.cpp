#include "fields/file/child_sandbox.h"

#include <fcntl.h>
#include <linux/landlock.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "fields/base/sanitizers.h"

namespace haarfield {
namespace {

// The rights of each version of the interface. Headers of Debian 12 lack the later ones.
constexpr std::uint64_t files_1 = (1u << 13) - 1, refer_2 = 1u << 13, truncate_3 = 1u << 14,
                        ioctl_5 = 1u << 15, network_4 = 3, scopes_6 = 3;
constexpr std::uint64_t reading =
    LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR | LANDLOCK_ACCESS_FS_EXECUTE;
constexpr std::uint64_t reading_a_file = LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_EXECUTE;

/// Allows accesses below a path. Ignores a path that does not exist.
bool allow(int rules, const std::filesystem::path& path, std::uint64_t accesses) {
    const int top = ::open(path.c_str(), O_PATH | O_CLOEXEC);
    if (top < 0) return true;
    const landlock_path_beneath_attr below{accesses, top};
    const bool good = ::syscall(SYS_landlock_add_rule, rules, LANDLOCK_RULE_PATH_BENEATH, &below, 0) == 0;
    ::close(top);
    return good;
}

bool limit(__rlimit_resource resource, std::uint64_t most) {
    rlimit now{};
    if (::getrlimit(resource, &now) != 0) return false;
    now.rlim_max = std::min<rlim_t>(now.rlim_max, most);
    now.rlim_cur = now.rlim_max;
    return ::setrlimit(resource, &now) == 0;
}

}  // namespace

Result<ChildSandbox> ChildSandbox::create(const ChildLimits& limits, bool with_files) {
    if (!with_files) return ChildSandbox(limits, -1);
    const long version = ::syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
    if (version < 1) return Error{"", "this system has no Landlock (Linux 5.13 or later)"};
    struct {
        std::uint64_t files, network, scopes;
    } handled{files_1, 0, 0};
    if (version >= 2) handled.files |= refer_2;
    if (version >= 3) handled.files |= truncate_3;
    if (version >= 4) handled.network = network_4;
    if (version >= 5) handled.files |= ioctl_5;
    if (version >= 6) handled.scopes = scopes_6;
    const std::size_t size = version >= 6 ? 24 : version >= 4 ? 16 : 8;
    const int rules = int(::syscall(SYS_landlock_create_ruleset, &handled, size, 0));
    if (rules < 0) return Error{"", "Landlock refuses a rule set"};
    ChildSandbox sandbox(limits, rules);
    std::error_code ignored;
    for (const std::filesystem::path& path : limits.readable) {
        const bool is_folder = std::filesystem::is_directory(path, ignored);
        if (!allow(rules, path, is_folder ? reading : reading_a_file))
            return Error{path.string(), "Landlock refuses a rule for this path"};
    }
    for (const std::filesystem::path& path : limits.writable)
        if (!allow(rules, path, handled.files & ~LANDLOCK_ACCESS_FS_EXECUTE))
            return Error{path.string(), "Landlock refuses a rule for this folder"};
    if (!allow(rules, "/dev/null", LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_WRITE_FILE))
        return Error{"/dev/null", "Landlock refuses a rule for this file"};
    return sandbox;
}

ChildSandbox::ChildSandbox(ChildSandbox&& other) noexcept
    : limits_(std::move(other.limits_)), rules_(std::exchange(other.rules_, -1)) {}

ChildSandbox::~ChildSandbox() {
    if (rules_ >= 0) ::close(rules_);
}

bool ChildSandbox::enter() const {
    const auto seconds =
        static_cast<std::uint64_t>(std::ceil(std::clamp(limits_.processor_seconds, 1.0, 1e7)));
    const bool good = limit(RLIMIT_FSIZE, limits_.file_bytes) && limit(RLIMIT_CPU, seconds) &&
                      limit(RLIMIT_CORE, 0) && (has_shadow_memory || limit(RLIMIT_AS, limits_.memory));
    if (rules_ < 0) return good;
    return good && ::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
           ::syscall(SYS_landlock_restrict_self, rules_, 0) == 0;
}

}  // namespace haarfield
