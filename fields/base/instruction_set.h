#pragma once
/// Vector instructions by name, so that machines of several kinds can be told to make the same bits.
///
/// A result's last bits depend on the width of the vectors. The sets that can be chosen have fused
/// multiply-add, by which the C library chooses its functions, too.

#include "fields/base/result.h"

#include <string>
#include <string_view>
#include <vector>

namespace haarfield {

/// Those that this machine has, as Highway names them, the best one first: `AVX3_ZEN4`, `AVX3`, `AVX2`; empty
/// if it has none of those that can be chosen.
std::vector<std::string> instruction_sets();

/// Uses this one for all that follows, here and in Embree. Before that the best one is used. Not while others
/// compute.
///
/// errors  (with an empty `where`) it is none of this machine's.
Result<Done> use_instruction_set(const std::string& name);

/// Returns the settings of Embree's devices: the instruction set, if one was chosen.
std::string embree_settings();

}  // namespace haarfield
