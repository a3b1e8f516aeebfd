#pragma once
/// What a model's file is made of.

#include "fields/base/affine_map.h"

#include <cstdint>
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

/// A light of a model's file, in the words of POV-Ray; its lengths are the file's.
struct ModelLight {
    enum class Kind : std::uint8_t { point, spot, cylinder, parallel };
    struct Area {
        Vec3f across{1, 0, 0}, along{0, 0, 1};
        std::uint32_t columns = 1, rows = 1;
        bool circular = false, orient = false, illumination = false;
    };
    std::string name;  ///< May be empty.
    Kind kind = Kind::point;
    Vec3f position{0, 0, 0}, target{0, 0, 0};  ///< In the file's world; they differ, of all kinds but point.
    Rgb colour{1, 1, 1};                       ///< As POV-Ray's.
    /// Then the colour is the intensity [W/sr], or of parallel light the irradiance [W/m^2], and light falls
    /// off with the square of the distance: glTF's.
    bool is_physical = false;
    float fade_distance = 0, fade_power = 0;                         ///< 0: does not fade.
    float radius = 0.5235988f, falloff = 0.7853982f, tightness = 0;  ///< Of a spot angles [rad].
    bool shadowless = false;
    std::optional<Area> area{};
};

/// Parts by their names, which differ, and where they stand.
struct ModelParts {
    std::vector<std::string> names;
    std::vector<ModelNode> nodes;  ///< In the order of the file; each part at least once.
    std::optional<ModelCamera> camera;
    std::vector<ModelLight> lights;  ///< In the order of the file.
    std::size_t unread_lights = 0;   ///< That are no plain data.
};

}  // namespace haarfield
