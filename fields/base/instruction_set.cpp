#include "fields/base/instruction_set.h"

#include <fmt/format.h>
#include <hwy/highway.h>

#include <algorithm>

namespace haarfield {
namespace {

/// Instruction sets in Highway's order of preference: the lowest bit is the best.
constexpr std::int64_t eligible = (HWY_AVX2 << 1) - 1;

std::int64_t& chosen() {
    static std::int64_t target = 0;  // 0: the best
    return target;
}

std::vector<std::int64_t> targets() {
    const std::int64_t used = chosen();
    if (used != 0) hwy::SetSupportedTargetsForTest(0);
    std::vector<std::int64_t> found;
    for (std::int64_t left = hwy::SupportedTargets() & HWY_TARGETS & eligible; left != 0; left &= left - 1)
        found.push_back(left & -left);
    if (used != 0) hwy::SetSupportedTargetsForTest(used);
    return found;
}

}  // namespace

std::vector<std::string> instruction_sets() {
    std::vector<std::string> names;
    for (const std::int64_t target : targets()) names.emplace_back(hwy::TargetName(target));
    return names;
}

Result<Done> use_instruction_set(const std::string& name) {
    const std::vector<std::int64_t> all = targets();
    const auto found = std::ranges::find(
        all, name, [](std::int64_t target) { return std::string(hwy::TargetName(target)); });
    if (found == all.end()) {
        std::string has;
        for (const std::string& other : instruction_sets()) has += (has.empty() ? "" : ", ") + other;
        return Error{"", fmt::format("instruction set {} is not supported by this machine; expected {}", name,
                                     has.empty() ? "a machine with AVX2" : has)};
    }
    chosen() = *found;
    hwy::SetSupportedTargetsForTest(*found);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    return Done{};
}

std::string embree_settings() {
    return chosen() == HWY_AVX2 ? "isa=avx2" : "";  // Embree's only AVX-512 kernels are its default
}

}  // namespace haarfield
