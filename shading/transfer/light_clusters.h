#pragma once
/// Clusters of concentrated light for frames: neighbouring lights are occluded together, except in penumbrae,
/// which are evaluated completely.

#include "shading/bake/source_light.h"

namespace haarfield {

/// Lights within a cone.
struct LightCluster {
    std::vector<DirectionalLight> lights;  ///< The first `tried` of them are tested: the central one, then
                                           ///< distant ones.
    std::size_t tried = 0;                 ///< Number of lights tested first, or all.
    Vec3f axis{0, 1, 0};                   ///< Axis of the cone; unit length.
    float cosine = 1, sine = 0;            ///< Of the largest angle between axis and light.
    std::array<Vec3f, 3> flux{Vec3f(0.0f), Vec3f(0.0f),
                              Vec3f(0.0f)};  ///< By channel: sum of irradiance * direction. [W/m^2]
};

/// Divides lights into clusters whose lights are within about this angle of their centre.
///
/// angle    [rad]
/// cost     microseconds for hundreds of lights.
std::vector<LightCluster> light_clusters(std::span<const DirectionalLight> lights, float angle = 0.06f);

/// The visibility of a cluster at a receiver.
enum class ClusterVisibility : std::uint8_t {
    unknown,  ///< Also if the receiver does not face all of it.
    lit,      ///< Completely visible.
    blocked,  ///< Completely occluded.
    partly,
};

/// Adds light as add_source_light, with fewer rays. If all tested lights of a cluster are visible, or none
/// is, the others are assumed to be the same.
///
/// visibility    by receiver and cluster: lit and blocked are used, unknown ones are determined and stored.
///           Empty: all unknown.
/// accuracy  occluders thinner than a cluster may be missed where they occlude less than all of it: 0.4 %
///           (RMS) of the light of two suns around a post. Specular terms are omitted below 1/5,000 of their
///           peak.
void add_clustered_light(const ShadowRays& rays, std::span<const LightCluster> clusters,
                         std::span<const ShadingPoint> receivers, std::span<Rgb> radiance,
                         std::span<Rgb> diffuse = {}, std::span<ClusterVisibility> visibility = {});

}  // namespace haarfield
