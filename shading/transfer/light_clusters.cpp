#include "shading/transfer/light_clusters.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace haarfield {
namespace {

constexpr std::size_t most_tried = 4;
constexpr float negligible_lobe = 2e-4f;  ///< Relative to the lobe's peak.

/// Moves the light nearest to the axis to the front. After it come lights that are each farthest from all
/// those before.
void put_tried_first(LightCluster& cluster) {
    std::vector<DirectionalLight>& lights = cluster.lights;
    cluster.tried = std::min(most_tried, lights.size());
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

/// Divides lights in the middle of their longest extent until they fit a box of the given size.
void cut(std::span<DirectionalLight> lights, float size, std::vector<LightCluster>& clusters) {
    Vec3f lower(2.0f), upper(-2.0f);
    for (const DirectionalLight& light : lights)
        for (int axis = 0; axis < 3; ++axis) {
            lower[axis] = std::min(lower[axis], light.direction[axis]);
            upper[axis] = std::max(upper[axis], light.direction[axis]);
        }
    const Vec3f extent = upper - lower;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    if (!(extent[axis] > size)) {
        clusters.push_back(cluster_of(lights));
        return;
    }
    const float middle = 0.5f * (lower[axis] + upper[axis]);
    const auto others =
        std::stable_partition(lights.begin(), lights.end(),
                              [&](const DirectionalLight& light) { return light.direction[axis] < middle; });
    cut({lights.begin(), others}, size, clusters);
    cut({others, lights.end()}, size, clusters);
}

/// The specular term of a receiver, and the directions in which it is not negligible.
struct SpecularTerm {
    VertexBrdf brdf;  ///< Without the diffuse term.
    float least = 2;  ///< Cosine to the mirror direction below which the term is negligible; above 1: no
                      ///< term.

    explicit SpecularTerm(const VertexBrdf& whole) : brdf(whole) {
        brdf.diffuse = Rgb(0.0f);
        if (!brdf.has_specular()) return;
        for (const Lobe& lobe : brdf.lobes)
            if (lobe.weight > 0)
                least = std::min(least, lobe.axis != LobeAxis::mirror || lobe.exponent == 0
                                            ? -2.0f
                                            : std::exp(std::log(negligible_lobe) / lobe.exponent));
    }

    bool may_show(const LightCluster& cluster) const {
        if (least > 1) return false;
        const float along = brdf.mirror.dot(cluster.axis);
        if (along >= cluster.cosine) return true;
        const float across = std::sqrt(std::max(0.0f, 1 - along * along));
        return along * cluster.cosine + across * cluster.sine >= least;
    }
};

/// A packet of neighbouring receivers, and the light added to them.
class LitPacket {
public:
    LitPacket(const ShadowRays& rays, std::span<const ShadingPoint> receivers, std::span<Rgb> radiance,
              std::span<Rgb> diffuse)
        : rays_(rays), receivers_(receivers), radiance_(radiance), diffuse_(diffuse) {
        specular_terms_.reserve(receivers.size());
        for (const ShadingPoint& receiver : receivers) specular_terms_.emplace_back(receiver.brdf);
    }

    /// visibility  those of the cluster: by receiver, `step` apart; or empty.
    void add(const LightCluster& cluster, std::span<ClusterVisibility> visibility, std::size_t step) {
        const auto visibility_at = [&](std::size_t i) {
            return visibility.empty() ? ClusterVisibility::unknown : visibility[i * step];
        };
        std::uint16_t whole = 0, part = 0;  // Faced by receivers of unknown visibility.
        for (std::size_t i = 0; i < receivers_.size(); ++i) {
            const float along = receivers_[i].brdf.normal.dot(cluster.axis);
            if (along < -cluster.sine || visibility_at(i) == ClusterVisibility::blocked) continue;
            const bool is_whole = along > cluster.sine;
            if (visibility_at(i) == ClusterVisibility::lit) {
                if (is_whole)
                    add_all(i, cluster);
                else
                    for (const DirectionalLight& light : cluster.lights) add_one(i, light);
                continue;
            }
            (is_whole ? whole : part) |= static_cast<std::uint16_t>(1u << i);
        }
        const auto faced = static_cast<std::uint16_t>(whole | part);
        if (!faced) return;
        std::array<std::uint16_t, most_tried> lit{};
        std::uint16_t all = whole, any = 0;
        for (std::size_t k = 0; k < cluster.tried; ++k) {
            lit[k] = receivers_.lit(rays_, cluster.lights[k].direction, faced);
            all &= lit[k];
            any |= lit[k];
        }
        for (std::size_t i = 0; i < receivers_.size(); ++i) {
            if (all >> i & 1u) add_all(i, cluster);
            if (visibility.empty() || !(whole >> i & 1u)) continue;
            visibility[i * step] = all >> i & 1u   ? ClusterVisibility::lit
                                   : any >> i & 1u ? ClusterVisibility::partly
                                                   : ClusterVisibility::blocked;
        }
        const auto mixed = static_cast<std::uint16_t>((whole & any & ~all) | part);
        if (!mixed) return;
        for (std::size_t k = 0; k < cluster.lights.size(); ++k) {
            const DirectionalLight& light = cluster.lights[k];
            const std::uint16_t seen =
                k < cluster.tried ? lit[k] & mixed : receivers_.lit(rays_, light.direction, mixed);
            for (std::size_t i = 0; i < receivers_.size(); ++i)
                if (seen >> i & 1u) add_one(i, light);
        }
    }

private:
    void add_all(std::size_t i, const LightCluster& cluster) {
        const VertexBrdf& brdf = receivers_[i].brdf;
        Rgb by_cosine;
        for (std::size_t c = 0; c < 3; ++c) by_cosine[static_cast<int>(c)] = brdf.normal.dot(cluster.flux[c]);
        const Rgb shed = brdf.diffuse * by_cosine;
        radiance_[i] += shed;
        if (!diffuse_.empty()) diffuse_[i] += shed;
        if (specular_terms_[i].may_show(cluster))
            for (const DirectionalLight& light : cluster.lights)
                radiance_[i] +=
                    reflectance(specular_terms_[i].brdf, light.direction).total() * light.irradiance;
    }

    void add_one(std::size_t i, const DirectionalLight& light) {
        const VertexBrdf& brdf = receivers_[i].brdf;
        const float cosine = brdf.normal.dot(light.direction);
        if (!(cosine > 0)) return;
        radiance_[i] += reflectance(brdf, light.direction).total() * light.irradiance;
        if (!diffuse_.empty()) diffuse_[i] += brdf.diffuse * light.irradiance * cosine;
    }

    const ShadowRays& rays_;
    ReceiverPacket receivers_;
    std::span<Rgb> radiance_, diffuse_;
    std::vector<SpecularTerm> specular_terms_;
};

}  // namespace

std::vector<LightCluster> light_clusters(std::span<const DirectionalLight> lights, float angle) {
    std::vector<LightCluster> clusters;
    if (lights.empty()) return clusters;
    std::vector<DirectionalLight> sorted(lights.begin(), lights.end());
    cut(sorted, 2 * angle / std::sqrt(2.0f), clusters);
    return clusters;
}

void add_clustered_light(const ShadowRays& rays, std::span<const LightCluster> clusters,
                         std::span<const ShadingPoint> receivers, std::span<Rgb> radiance,
                         std::span<Rgb> diffuse, std::span<ClusterVisibility> visibility) {
    assert(receivers.size() == radiance.size());
    assert(diffuse.empty() || diffuse.size() == radiance.size());
    assert(visibility.empty() || visibility.size() == receivers.size() * clusters.size());
    constexpr std::size_t packet = ShadowRays::packet;
    for (std::size_t first = 0; first < receivers.size(); first += packet) {
        const std::size_t count = std::min(packet, receivers.size() - first);
        LitPacket here(rays, receivers.subspan(first, count), radiance.subspan(first, count),
                       diffuse.empty() ? diffuse : diffuse.subspan(first, count));
        for (std::size_t c = 0; c < clusters.size(); ++c)
            here.add(clusters[c],
                     visibility.empty() ? visibility : visibility.subspan(first * clusters.size() + c),
                     clusters.size());
    }
}

}  // namespace haarfield
