#pragma once
/// Concentrated light for frames: lights side by side are seen or hidden together, but in the penumbrae that
/// are looked at in full.

#include "shading/bake/source_light.h"

namespace haarfield {

/// Lights within a cone.
struct LightCluster {
    std::vector<DirectionalLight> lights;  ///< The first of them are tried: from the middle, then far apart.
    std::size_t tried = 0;                 ///< So many; all, if there are no more than that.
    Vec3f axis{0, 1, 0};                   ///< Of the cone; unit length.
    float cosine = 1, sine = 0;            ///< Of the angle to the light that is farthest from it.
    std::array<Vec3f, 3> flux{Vec3f(0.0f), Vec3f(0.0f),
                              Vec3f(0.0f)};  ///< By channel: sum of irradiance * direction. [W/m^2]
};

/// Parts lights into clusters, each of at most this angle from its middle to the farthest in it, or little
/// more.
///
/// angle    [rad]
/// cost     microseconds for hundreds of lights.
std::vector<LightCluster> light_clusters(std::span<const DirectionalLight> lights, float angle = 0.06f);

/// What of a cluster a receiver sees.
enum class ClusterSight : std::uint8_t {
    unknown,  ///< Also if the receiver does not face all of it.
    lit,      ///< All.
    blocked,  ///< Nothing.
    partly,
};

/// As add_source_light, with fewer rays: what blocks all lights of a cluster that are tried, or none, does so
/// with the others, too.
///
/// sights    by receiver and cluster: lit and blocked are believed, what is unknown is found and told; or
///           none: nothing is known.
/// accuracy  what is thinner than a cluster may be missed where it hides less than all of it: 0.4 % (RMS) of
///           the light of two suns round a post. Highlights are left out where they are below a 5,000th of
///           their peak.
void add_clustered_light(const ShadowRays& rays, std::span<const LightCluster> clusters,
                         std::span<const SourceReceiver> receivers, std::span<Rgb> radiance,
                         std::span<Rgb> diffuse = {}, std::span<ClusterSight> sights = {});

}  // namespace haarfield
