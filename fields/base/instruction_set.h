#pragma once
/// Selection of the vector instruction set by name, so that machines of different kinds compute bit-identical
/// results.
///
/// The last bits of a result depend on the vector width. All selectable sets have fused multiply-add, because
/// the C library chooses its functions by it, too.

#include "fields/base/result.h"

#include <string>
#include <string_view>
#include <vector>

namespace haarfield {

/// Returns the sets that this machine supports, best first, by Highway's names: `AVX3_ZEN4`, `AVX3`, `AVX2`.
/// Empty if it supports none of the selectable sets.
std::vector<std::string> instruction_sets();

/// Uses an instruction set for all further computations, in this library and in Embree. The default is the
/// best one. Must not be called while other threads compute.
///
/// errors  (with an empty `where`) the machine does not support it.
Result<Done> use_instruction_set(const std::string& name);

/// Returns the settings of Embree's devices: the instruction set, if one was chosen.
std::string embree_settings();

}  // namespace haarfield
