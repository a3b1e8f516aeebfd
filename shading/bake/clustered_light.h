#pragma once
/// Radiance of points by clusters of concentrated light: penumbrae are evaluated completely, other places
/// with few rays.

#include "shading/bake/source_light.h"
#include "shading/scene/light_clusters.h"

namespace haarfield {

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
/// visibility  by receiver and cluster: lit and blocked are used, unknown ones are determined and stored.
///             Empty: all unknown.
/// accuracy    occluders thinner than a cluster may be missed where they occlude less than all of it: 0.4 %
///             (RMS) of the light of two suns around a post. Specular terms are omitted below 1/5,000 of
///             their peak.
void add_clustered_light(const ShadowRays& rays, std::span<const LightCluster> clusters,
                         std::span<const ShadingPoint> receivers, std::span<Rgb> radiance,
                         std::span<Rgb> diffuse = {}, std::span<ClusterVisibility> visibility = {});

/// Adds light to both components of the radiance, with the same accuracy.
void add_clustered_light(const ShadowRays& rays, std::span<const LightCluster> clusters,
                         std::span<const ShadingPoint> receivers, std::span<Outgoing> radiance);

}  // namespace haarfield
