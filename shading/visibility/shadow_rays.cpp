#include "shading/visibility/shadow_rays.h"

#include <cassert>

#include "fields/base/embree_rays.h"

namespace haarfield {
namespace {

constexpr unsigned everything = ~0u;

/// Returns a mask that all instances but one share a bit with.
unsigned mask_without(std::size_t instance) {
    return instance == ShadowRays::no_instance ? everything : ~instance_mask(instance);
}

/// Tests which of at most 16 wanted rays hit an instance of the mask.
///
/// way  takes the index of a point; returns the direction to the light, scaled so that the ray ends at
///      `range`.
template <class Way>
std::uint16_t hits(RTCScene scene, std::span<const Vec3f> points, std::uint16_t wanted, const Way& way,
                   float range, unsigned mask) {
    assert(points.size() <= ShadowRays::packet);
    if (wanted == 0) return 0;
    RTCRay16 rays;
    alignas(64) std::array<int, ShadowRays::packet> valid;
    for (std::size_t i = 0; i < ShadowRays::packet; ++i) {
        const bool matters = i < points.size() && (wanted >> i & 1u) != 0;
        valid[i] = matters ? -1 : 0;
        set_ray(rays, i, matters ? points[i] : Vec3f(0.0f), matters ? way(i) : Vec3f(0, 1, 0), range, mask);
    }
    // Coherent packets do not always return from robust scenes of instances in Embree 3.
    test_occlusion(scene, valid.data(), rays, Coherence::none);
    std::uint16_t result = 0;
    for (std::size_t i = 0; i < ShadowRays::packet; ++i)
        if (valid[i] != 0 && rays.tfar[i] < 0) result = static_cast<std::uint16_t>(result | 1u << i);
    return result;
}

}  // namespace

void ShadowRays::build(const ShadedScene& scene) {
    triangles_ = {};
    for (const ShadedEntity& entity : scene.entities) {
        const Occluder& original = entity.occlusion->original();
        triangles_.add_entity(original.positions(), original.triangles());
    }
    place(scene);
}

std::uint16_t ShadowRays::blocked(std::span<const Vec3f> points, std::uint16_t wanted, const Vec3f& direction,
                                  std::size_t without) const {
    return hits(
        triangles_.scene(), points, wanted, [&](std::size_t) { return direction; }, far_away,
        mask_without(without));
}

std::uint16_t ShadowRays::blocked_from(std::span<const Vec3f> points, std::uint16_t wanted,
                                       std::span<const Vec3f> ends, std::size_t without) const {
    assert(ends.size() == points.size());
    return hits(
        triangles_.scene(), points, wanted, [&](std::size_t i) { return ends[i] - points[i]; }, 1 - last_part,
        mask_without(without));
}

bool ShadowRays::is_blocked_from(const Vec3f& point, const Vec3f& end, std::size_t without) const {
    return blocked_from({&point, 1}, 1, {&end, 1}, without) != 0;
}

bool ShadowRays::is_blocked(const Vec3f& point, const Vec3f& direction) const {
    return meets_any(triangles_.scene(), embree_ray(point, direction, far_away));
}

}  // namespace haarfield
