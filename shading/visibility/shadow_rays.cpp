#include "shading/visibility/shadow_rays.h"

#include <cassert>

#include "fields/base/embree_rays.h"

namespace haarfield {
namespace {

constexpr unsigned everything = ~0u;
static_assert(ShadowRays::packet == packet_rays);

/// Returns a mask that all instances but one share a bit with.
unsigned mask_without(std::size_t instance) {
    return instance == ShadowRays::no_instance ? everything : ~instance_mask(instance);
}

/// Returns the bits of `wanted` that have a point.
std::uint16_t with_points(std::uint16_t wanted, std::span<const Vec3f> points) {
    assert(points.size() <= ShadowRays::packet);
    return static_cast<std::uint16_t>(wanted & ((1u << points.size()) - 1));
}

}  // namespace

void ShadowRays::build(const ShadedScene& scene) {
    triangles_ = {};
    filters_ = scene.filters;
    for (const ShadedEntity& entity : scene.entities) {
        const Occluder& original = entity.occlusion->original();
        triangles_.add_entity(original.positions(), original.triangles());
    }
    place(scene);
}

std::uint16_t ShadowRays::blocked(std::span<const Vec3f> points, std::uint16_t wanted, const Vec3f& direction,
                                  std::size_t without) const {
    return blocked_rays(
        triangles_.scene(), with_points(wanted, points), [&](std::size_t i) { return points[i]; },
        [&](std::size_t) { return direction; }, far_away, mask_without(without));
}

std::uint16_t ShadowRays::blocked_from(std::span<const Vec3f> points, std::uint16_t wanted,
                                       std::span<const Vec3f> ends, std::size_t without) const {
    assert(ends.size() == points.size());
    return blocked_rays(
        triangles_.scene(), with_points(wanted, points), [&](std::size_t i) { return points[i]; },
        [&](std::size_t i) { return ends[i] - points[i]; }, 1 - last_part, mask_without(without));
}

bool ShadowRays::is_blocked_from(const Vec3f& point, const Vec3f& end, std::size_t without) const {
    return blocked_from({&point, 1}, 1, {&end, 1}, without) != 0;
}

bool ShadowRays::is_blocked(const Vec3f& point, const Vec3f& direction) const {
    return meets_any(triangles_.scene(), embree_ray(point, direction, far_away));
}

}  // namespace haarfield
