#include "shading/bake/emitter_light.h"

#include <algorithm>
#include <cassert>

namespace haarfield {
namespace {

/// Fraction of the mean irradiance per patch below which a patch has no shadow ray. Its visibility is then
/// the mean visibility of the patches with rays. The same applies to patches beyond EmitterCut::most.
constexpr float negligible = 0.02f;

/// Returns the radiance of a point by an unoccluded patch.
Outgoing radiance_by(const EmitterPatch& patch, const VertexBrdf& brdf) {
    return {brdf.diffuse * patch.irradiance,
            specular_reflectance(brdf, patch.direction, patch.spread) * patch.facing};
}

/// Computes the emitters' light at receivers one at a time. Reuses its memory.
class Receiver {
public:
    Receiver(const ShadowRays& rays, const EmitterTree& emitters, const EmitterCut& cut)
        : rays_(rays), emitters_(emitters), cut_(cut) {}

    Outgoing radiance(const ShadingPoint& receiver) {
        find_patches(emitters_, receiver.position, receiver.brdf.normal, cut_, patches_);
        float light = 0;
        for (const EmitterPatch& patch : patches_) light += luminance(patch.irradiance);
        const float least =
            negligible * light / static_cast<float>(std::max<std::size_t>(patches_.size(), 1));
        const auto last = std::stable_partition(
            patches_.begin(), patches_.end(),
            [&](const EmitterPatch& patch) { return luminance(patch.irradiance) >= least; });
        std::size_t looked_at = static_cast<std::size_t>(last - patches_.begin());
        if (looked_at > cut_.most) {
            std::stable_sort(patches_.begin(), last, [](const EmitterPatch& a, const EmitterPatch& b) {
                return luminance(a.irradiance) > luminance(b.irradiance);
            });
            looked_at = cut_.most;
        }
        Outgoing sum, rest;
        float open = 0, all = 0;
        for (std::size_t first = 0; first < looked_at; first += ShadowRays::packet) {
            const std::size_t count = std::min(ShadowRays::packet, looked_at - first);
            const std::uint16_t blocked = blocked_of(receiver.from, first, count);
            for (std::size_t i = 0; i < count; ++i) {
                const EmitterPatch& patch = patches_[first + i];
                all += luminance(patch.irradiance);
                if (blocked >> i & 1u) continue;
                open += luminance(patch.irradiance);
                sum += radiance_by(patch, receiver.brdf);
            }
        }
        if (!(open > 0)) return sum;
        for (std::size_t i = looked_at; i < patches_.size(); ++i)
            rest += radiance_by(patches_[i], receiver.brdf);
        return sum + rest * (open / all);
    }

private:
    std::uint16_t blocked_of(const Vec3f& from, std::size_t first, std::size_t count) {
        std::array<Vec3f, ShadowRays::packet> points, ends;
        points.fill(from);
        for (std::size_t i = 0; i < count; ++i) ends[i] = patches_[first + i].place;
        return rays_.blocked_from(std::span(points).first(count),
                                  static_cast<std::uint16_t>((1u << count) - 1),
                                  std::span(ends).first(count));
    }

    const ShadowRays& rays_;
    const EmitterTree& emitters_;
    const EmitterCut cut_;
    std::vector<EmitterPatch> patches_;
};

}  // namespace

void add_emitter_light(const ShadowRays& rays, const EmitterTree& emitters,
                       std::span<const ShadingPoint> receivers, std::span<Outgoing> radiance,
                       const EmitterCut& cut) {
    assert(receivers.size() == radiance.size());
    if (emitters.empty()) return;
    Receiver lit(rays, emitters, cut);
    for (std::size_t i = 0; i < receivers.size(); ++i) radiance[i] += lit.radiance(receivers[i]);
}

}  // namespace haarfield
