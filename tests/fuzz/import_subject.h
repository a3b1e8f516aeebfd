#pragma once
/// The kind of haarfield_fuzz that imports and bakes whole models with all their files.

#include <memory>

#include "tests/fuzz/subject.h"

namespace haarfield {

/// Models with materials, buffers and images, of which some are damaged or refer to other folders. `import`
/// and `bake` reject them with a place and a reason and leave no scene, or bake them to finite numbers. No
/// file outside of the model's folder is opened, and none outside of the output's folder is written.
///
/// A file contains all files of a model in turn: a line with name and size, then the bytes.
std::unique_ptr<Subject> damaged_models();

}  // namespace haarfield
