#pragma once
/// The components of a model's file.

#include "fields/base/affine_map.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace haarfield {

/// A placement of a part of a model.
struct ModelNode {
    std::string name;  ///< As in the file; may be empty, and need not be unique.
    std::size_t part = 0;
    AffineMap place{};  ///< From the part's frame to the file's world.
};

/// A camera of a model's file.
struct ModelCamera {
    Vec3f position, direction;            ///< In the file's world; of any non-zero length.
    std::optional<float> vertical_fov{};  ///< Full angle. [rad]
};

/// A light of a model's file, in POV-Ray's terms. Lengths are in the file's unit.
struct ModelLight {
    /// POV-Ray's kinds of lights.
    enum class Kind : std::uint8_t { point, spot, cylinder, parallel };
    /// POV-Ray's area_light.
    struct Area {
        Vec3f across{1, 0, 0}, along{0, 0, 1};
        std::uint32_t columns = 1, rows = 1;
        bool circular = false, orient = false, illumination = false;
    };
    std::string name;  ///< May be empty.
    Kind kind = Kind::point;
    Vec3f position{0, 0, 0}, target{0, 0, 0};  ///< In the file's world. They differ, except for point lights.
    Rgb colour{1, 1, 1};                       ///< As in POV-Ray.
    /// As in glTF: the colour is the intensity [W/sr], or for parallel light the irradiance [W/m^2]. Light
    /// falls off with the square of the distance.
    bool is_physical = false;
    float fade_distance = 0, fade_power = 0;                         ///< 0: does not fade.
    float radius = 0.5235988f, falloff = 0.7853982f, tightness = 0;  ///< For spots, angles [rad].
    bool shadowless = false;
    std::optional<Area> area{};
};

/// Parts with unique names, and their placements.
struct ModelParts {
    std::vector<std::string> names;
    std::vector<ModelNode> nodes;  ///< In the order of the file; each part at least once.
    std::optional<ModelCamera> camera;
    std::vector<ModelLight> lights;  ///< In the order of the file.
    std::size_t unread_lights = 0;   ///< The number of lights that are not plain data.
};

}  // namespace haarfield
