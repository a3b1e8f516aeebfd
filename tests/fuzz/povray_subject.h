#pragma once
/// The kind of haarfield_fuzz that imports POV-Ray scenes, which POV-Ray evaluates in its sandbox.

#include <memory>

#include "tests/fuzz/subject.h"

namespace haarfield {

/// POV-Ray scenes with damaged text and with statements that loop forever, request memory, reuse the names of
/// the import, or read and write files of other folders. `import` refuses them with a reason, or writes a
/// scene that can be read again. No file outside of the scene's folder is opened, and none outside of the
/// output's folder is written. The import ends even if POV-Ray would not.
std::unique_ptr<Subject> damaged_povray_scenes();

}  // namespace haarfield
