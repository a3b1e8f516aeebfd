#pragma once
/// The kind of haarfield_fuzz that is a whole model: with what it refers to, imported and baked.

#include <memory>

#include "tests/fuzz/subject.h"

namespace haarfield {

/// Models with their materials, buffers and images, of which some are damaged, or named elsewhere: `import`
/// and `bake` refuse them with a place and a reason and leave no scene, or bake them to numbers that are
/// finite. No file outside of the model's folder is opened, or written outside of the output's.
///
/// A file holds all that a model consists of, one after the other: a line of name and size, then the bytes.
std::unique_ptr<Subject> damaged_models();

}  // namespace haarfield
