#pragma once
/// What a model's file is made of.

#include "fields/base/affine_map.h"

#include <optional>
#include <string>
#include <vector>

namespace haarfield {

/// A piece of a model that its file places once or more.
struct ModelNode {
    std::string name;  ///< As the file has it; may be empty, and the same as another's.
    std::size_t part = 0;
    AffineMap place{};  ///< From the part to the file's world.
};

/// A camera of a model's file.
struct ModelCamera {
    Vec3f position, direction;            ///< In the file's world; of any length but 0.
    std::optional<float> vertical_fov{};  ///< Full angle. [rad]
};

/// Parts by their names, which differ, and where they stand.
struct ModelParts {
    std::vector<std::string> names;
    std::vector<ModelNode> nodes;  ///< In the order of the file; each part at least once.
    std::optional<ModelCamera> camera;
};

}  // namespace haarfield
