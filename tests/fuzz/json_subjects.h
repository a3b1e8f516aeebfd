#pragma once
/// Kinds of haarfield_fuzz that are JSON: plans, and what pages say to `haarfield view`.

#include <memory>

#include "tests/fuzz/subject.h"

namespace haarfield {

/// Plans, as `work`, `join` and `status` read them: refused with a reason and a place, or such that every
/// task is there, every time is a number, every job a command's in as many parts as it can have, and writing
/// and reading them again changes nothing.
std::unique_ptr<Subject> damaged_plans();

/// Messages: refused with a reason that can be sent, or in their ranges (message_defect).
std::unique_ptr<Subject> damaged_messages();

}  // namespace haarfield
