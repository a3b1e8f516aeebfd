#include "shading/bake/clustered_light.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace haarfield {
namespace {

constexpr float negligible_lobe = 2e-4f;  ///< Relative to the lobe's peak.

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

/// The radiance of receivers, and its diffuse component if that is wanted.
struct TotalRadiance {
    std::span<Rgb> radiance, diffuse;

    void add_diffuse(std::size_t i, const Rgb& added) const {
        radiance[i] += added;
        if (!diffuse.empty()) diffuse[i] += added;
    }
    void add_specular(std::size_t i, const Rgb& added) const { radiance[i] += added; }
    void add(std::size_t i, const Outgoing& added) const {
        radiance[i] += added.total();
        if (!diffuse.empty()) diffuse[i] += added.diffuse;
    }
};

/// Both components of the radiance of receivers.
struct RadianceComponents {
    std::span<Outgoing> radiance;

    void add_diffuse(std::size_t i, const Rgb& added) const { radiance[i].diffuse += added; }
    void add_specular(std::size_t i, const Rgb& added) const { radiance[i].specular += added; }
    void add(std::size_t i, const Outgoing& added) const { radiance[i] += added; }
};

/// A packet of neighbouring receivers, and the light added to them.
///
/// Radiance  TotalRadiance or RadianceComponents.
template <class Radiance>
class LitPacket {
public:
    LitPacket(const ShadowRays& rays, std::span<const ShadingPoint> receivers, const Radiance& radiance)
        : rays_(rays), receivers_(receivers), radiance_(radiance) {
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
        std::array<std::uint16_t, LightCluster::most_tried> lit{};
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
        radiance_.add_diffuse(i, brdf.diffuse * by_cosine);
        if (specular_terms_[i].may_show(cluster))
            for (const DirectionalLight& light : cluster.lights)
                radiance_.add_specular(
                    i, reflectance(specular_terms_[i].brdf, light.direction).total() * light.irradiance);
    }

    void add_one(std::size_t i, const DirectionalLight& light) {
        const VertexBrdf& brdf = receivers_[i].brdf;
        if (!(brdf.normal.dot(light.direction) > 0)) return;
        radiance_.add(i, reflectance(brdf, light.direction) * light.irradiance);
    }

    const ShadowRays& rays_;
    ReceiverPacket receivers_;
    const Radiance radiance_;
    std::vector<SpecularTerm> specular_terms_;
};

/// Adds light to all receivers.
///
/// part  (std::size_t first, std::size_t count) -> TotalRadiance or RadianceComponents, of these receivers.
template <class Part>
void add_to(const ShadowRays& rays, std::span<const LightCluster> clusters,
            std::span<const ShadingPoint> receivers, std::span<ClusterVisibility> visibility,
            const Part& part) {
    constexpr std::size_t packet = ShadowRays::packet;
    for (std::size_t first = 0; first < receivers.size(); first += packet) {
        const std::size_t count = std::min(packet, receivers.size() - first);
        LitPacket here(rays, receivers.subspan(first, count), part(first, count));
        for (std::size_t c = 0; c < clusters.size(); ++c)
            here.add(clusters[c],
                     visibility.empty() ? visibility : visibility.subspan(first * clusters.size() + c),
                     clusters.size());
    }
}

}  // namespace

void add_clustered_light(const ShadowRays& rays, std::span<const LightCluster> clusters,
                         std::span<const ShadingPoint> receivers, std::span<Rgb> radiance,
                         std::span<Rgb> diffuse, std::span<ClusterVisibility> visibility) {
    assert(receivers.size() == radiance.size());
    assert(diffuse.empty() || diffuse.size() == radiance.size());
    assert(visibility.empty() || visibility.size() == receivers.size() * clusters.size());
    const auto part = [&](std::size_t first, std::size_t count) -> TotalRadiance {
        return {radiance.subspan(first, count), diffuse.empty() ? diffuse : diffuse.subspan(first, count)};
    };
    add_to(rays, clusters, receivers, visibility, part);
}

void add_clustered_light(const ShadowRays& rays, std::span<const LightCluster> clusters,
                         std::span<const ShadingPoint> receivers, std::span<Outgoing> radiance) {
    assert(receivers.size() == radiance.size());
    add_to(rays, clusters, receivers, {}, [&](std::size_t first, std::size_t count) -> RadianceComponents {
        return {radiance.subspan(first, count)};
    });
}

}  // namespace haarfield
