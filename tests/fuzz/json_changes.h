#pragma once
/// Changes to JSON that know its tree.

#include <nlohmann/json.hpp>

#include "tests/fuzz/fuzz_inputs.h"

namespace haarfield {

/// Changes one to some ten values, anywhere in the tree: a number by one, by its sign, by powers of two up to
/// the ends of doubles and of 64 bits; a value to one of another kind, or to another of the tree; keys and
/// elements left out, doubled or exchanged; names of keys; texts made longer, or of odd characters; a value
/// many levels down. The text need be no JSON that every program reads: infinities are not written as null.
std::string changed_json(nlohmann::ordered_json json, FuzzRandom& random);

}  // namespace haarfield
