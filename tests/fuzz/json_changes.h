#pragma once
/// Structural changes to JSON.

#include <nlohmann/json.hpp>

#include "tests/fuzz/fuzz_inputs.h"

namespace haarfield {

/// Changes one to about ten values anywhere in the tree. A number changes by one, by its sign, or by powers
/// of two up to the limits of doubles and of 64 bits. A value changes to another type or to another value of
/// the tree. Keys and elements are removed, duplicated or swapped, keys renamed, texts extended or filled
/// with unusual characters, and values nested deeply. The result need not be JSON that every program reads:
/// infinities are not written as null.
std::string changed_json(nlohmann::ordered_json json, FuzzRandom& random);

}  // namespace haarfield
