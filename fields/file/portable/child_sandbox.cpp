#include "fields/file/child_sandbox.h"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>

namespace haarfield {
namespace {

bool limit(int resource, std::uint64_t most) {
    rlimit now{};
    if (::getrlimit(resource, &now) != 0) return false;
    now.rlim_max = std::min<rlim_t>(now.rlim_max, most);
    now.rlim_cur = now.rlim_max;
    return ::setrlimit(resource, &now) == 0;
}

}  // namespace

Result<ChildSandbox> ChildSandbox::create(const ChildLimits& limits, bool with_files) {
    if (with_files) return Error{"", "this system has no Landlock (Linux 5.13 or later)"};
    return ChildSandbox(limits, -1);
}

ChildSandbox::ChildSandbox(ChildSandbox&& other) noexcept
    : limits_(std::move(other.limits_)), rules_(other.rules_) {}

ChildSandbox::~ChildSandbox() = default;

bool ChildSandbox::enter() const {
    const auto seconds =
        static_cast<std::uint64_t>(std::ceil(std::clamp(limits_.processor_seconds, 1.0, 1e7)));
    return limit(RLIMIT_FSIZE, limits_.file_bytes) && limit(RLIMIT_CPU, seconds) &&
           limit(RLIMIT_AS, limits_.memory);
}

}  // namespace haarfield
