#include "shading/scene/light_clusters.h"

#include <algorithm>
#include <cmath>

namespace haarfield {
namespace {

/// Moves the light nearest to the axis to the front. After it come lights that are each farthest from all
/// those before.
void put_tried_first(LightCluster& cluster) {
    std::vector<DirectionalLight>& lights = cluster.lights;
    cluster.tried = std::min(LightCluster::most_tried, lights.size());
    const auto middle = std::ranges::max_element(
        lights, {}, [&](const DirectionalLight& light) { return light.direction.dot(cluster.axis); });
    std::iter_swap(lights.begin(), middle);
    for (std::size_t k = 1; k < cluster.tried; ++k) {
        const auto nearness = [&](const DirectionalLight& light) {
            float nearest = -1;
            for (std::size_t i = 0; i < k; ++i)
                nearest = std::max(nearest, light.direction.dot(lights[i].direction));
            return nearest;
        };
        const auto next = lights.begin() + static_cast<std::ptrdiff_t>(k);
        std::iter_swap(next, std::ranges::min_element(next, lights.end(), {}, nearness));
    }
}

LightCluster cluster_of(std::span<const DirectionalLight> lights) {
    LightCluster cluster;
    cluster.lights.assign(lights.begin(), lights.end());
    Vec3f sum(0.0f);
    for (const auto& [direction, irradiance] : lights) {
        sum += direction;
        for (std::size_t c = 0; c < 3; ++c) cluster.flux[c] += direction * irradiance[static_cast<int>(c)];
    }
    cluster.axis = sum.normalized();
    for (const DirectionalLight& light : lights)
        cluster.cosine = std::min(cluster.cosine, light.direction.dot(cluster.axis));
    cluster.sine = std::sqrt(std::max(0.0f, 1 - cluster.cosine * cluster.cosine));
    put_tried_first(cluster);
    return cluster;
}

/// Divides lights in the middle of their longest extent until they fit a box of the given size and are not
/// too many.
void cut(std::span<DirectionalLight> lights, float size, std::size_t most,
         std::vector<LightCluster>& clusters) {
    Vec3f lower(2.0f), upper(-2.0f);
    for (const DirectionalLight& light : lights)
        for (int axis = 0; axis < 3; ++axis) {
            lower[axis] = std::min(lower[axis], light.direction[axis]);
            upper[axis] = std::max(upper[axis], light.direction[axis]);
        }
    const Vec3f extent = upper - lower;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    const float middle = 0.5f * (lower[axis] + upper[axis]);
    const bool fits = !(extent[axis] > size) && lights.size() <= most;
    // Between equal or adjacent numbers there is no middle.
    if (fits || !(middle > lower[axis])) {
        clusters.push_back(cluster_of(lights));
        return;
    }
    const auto others =
        std::stable_partition(lights.begin(), lights.end(),
                              [&](const DirectionalLight& light) { return light.direction[axis] < middle; });
    cut({lights.begin(), others}, size, most, clusters);
    cut({others, lights.end()}, size, most, clusters);
}

}  // namespace

std::vector<LightCluster> light_clusters(std::span<const DirectionalLight> lights, float angle,
                                         std::size_t most) {
    std::vector<LightCluster> clusters;
    if (lights.empty()) return clusters;
    std::vector<DirectionalLight> sorted(lights.begin(), lights.end());
    cut(sorted, 2 * angle / std::sqrt(2.0f), most, clusters);
    return clusters;
}

}  // namespace haarfield
