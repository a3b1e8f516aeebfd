#pragma once
/// Clusters of concentrated light: neighbouring lights are occluded together, except in penumbrae.

#include <array>
#include <limits>

#include "shading/scene/light_sources.h"

namespace haarfield {

/// Lights within a cone.
struct LightCluster {
    static constexpr std::size_t most_tried = 4;  ///< The most lights that are tested first.

    std::vector<DirectionalLight> lights;  ///< The first `tried` of them are tested: the central one, then
                                           ///< distant ones.
    std::size_t tried = 0;                 ///< Number of lights that are tested first.
    Vec3f axis{0, 1, 0};                   ///< Axis of the cone; unit length.
    float cosine = 1, sine = 0;            ///< Of the largest angle between axis and light.
    std::array<Vec3f, 3> flux{Vec3f(0.0f), Vec3f(0.0f),
                              Vec3f(0.0f)};  ///< By channel: sum of irradiance * direction. [W/m^2]
};

/// Divides lights into clusters whose lights are within about this angle of their centre.
///
/// angle  [rad]
/// most   the largest number of lights of a cluster. Equal directions are not separated.
/// cost   microseconds for hundreds of lights.
std::vector<LightCluster> light_clusters(std::span<const DirectionalLight> lights, float angle = 0.06f,
                                         std::size_t most = std::numeric_limits<std::size_t>::max());

}  // namespace haarfield
