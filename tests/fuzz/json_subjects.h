#pragma once
/// Kinds of haarfield_fuzz that are JSON: plans, and messages from pages to `haarfield view`.

#include <memory>

#include "tests/fuzz/subject.h"

namespace haarfield {

/// Plans, as read by `work`, `join` and `status`. Each is rejected with a reason and a place, or valid: every
/// task exists, every time is a number, every job is a known command with a valid number of parts, and a
/// second write and read changes nothing.
std::unique_ptr<Subject> damaged_plans();

/// Messages: rejected with a reason that can be sent, or within their ranges (message_defect).
std::unique_ptr<Subject> damaged_messages();

}  // namespace haarfield
