#pragma once
/// Rays in scenes of Embree 3 or 4. The only include of Embree's headers, and not for users of the libraries.

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <array>
#include <cstdint>
#include <optional>

#include "fields/base/vector.h"

namespace haarfield {

/// Similarity of the directions in a packet. It changes the speed, not the hits.
enum class Coherence { none, high };

#if RTC_VERSION_MAJOR < 4
/// The arguments that Embree 3 has for all rays of a query.
inline RTCIntersectContext embree_context(Coherence coherence) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    if (coherence == Coherence::high) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    return context;
}
#endif

inline constexpr std::size_t packet_rays = 16;  ///< Rays of a packet.

/// Sets a ray of a packet, from `from` to `from + range * direction`. [m]
inline void set_ray(RTCRay16& rays, std::size_t i, const Vec3f& from, const Vec3f& direction, float range,
                    unsigned mask = ~0u) {
    rays.org_x[i] = from.x;
    rays.org_y[i] = from.y;
    rays.org_z[i] = from.z;
    rays.dir_x[i] = direction.x;
    rays.dir_y[i] = direction.y;
    rays.dir_z[i] = direction.z;
    rays.tnear[i] = rays.time[i] = 0;
    rays.tfar[i] = range;
    rays.mask[i] = mask;
    rays.id[i] = rays.flags[i] = 0;
}

/// Sets `tfar` of each ray with a nonzero `valid` that hits something to a negative number.
inline void test_occlusion(RTCScene scene, const int* valid, RTCRay16& rays, Coherence coherence) {
#if RTC_VERSION_MAJOR < 4
    RTCIntersectContext context = embree_context(coherence);
    rtcOccluded16(valid, scene, &context, &rays);
#else
    RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    if (coherence == Coherence::high) arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
    rtcOccluded16(valid, scene, &rays, &arguments);
#endif
}

/// Tests which rays of a packet hit something: bit i of the result for ray i.
///
/// wanted  bit i: test ray i; other bits of the result are 0.
/// from    (std::size_t i) -> Vec3f: the origin of a wanted ray.
/// way     (std::size_t i) -> Vec3f: its direction, scaled so that the ray ends at `range`.
template <class From, class Way>
std::uint16_t blocked_rays(RTCScene scene, std::uint16_t wanted, const From& from, const Way& way,
                           float range, unsigned mask = ~0u) {
    if (wanted == 0) return 0;
    RTCRay16 rays;
    alignas(64) std::array<int, packet_rays> valid;
    for (std::size_t i = 0; i < packet_rays; ++i) {
        const bool matters = (wanted >> i & 1u) != 0;
        valid[i] = matters ? -1 : 0;
        set_ray(rays, i, matters ? from(i) : Vec3f(0.0f), matters ? way(i) : Vec3f(0, 1, 0), range, mask);
    }
    // Coherent packets do not always return from robust scenes of instances in Embree 3.
    test_occlusion(scene, valid.data(), rays, Coherence::none);
    std::uint16_t result = 0;
    for (std::size_t i = 0; i < packet_rays; ++i)
        if (valid[i] != 0 && rays.tfar[i] < 0) result = static_cast<std::uint16_t>(result | 1u << i);
    return result;
}

/// Sets the nearest hit of each ray with a nonzero `valid`. Its geomID is RTC_INVALID_GEOMETRY_ID if there is
/// none.
inline void find_hits(RTCScene scene, const int* valid, RTCRayHit16& rays, Coherence coherence) {
    for (std::size_t i = 0; i < packet_rays; ++i)
        rays.hit.geomID[i] = rays.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR < 4
    RTCIntersectContext context = embree_context(coherence);
    rtcIntersect16(valid, scene, &context, &rays);
#else
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    if (coherence == Coherence::high) arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
    rtcIntersect16(valid, scene, &rays, &arguments);
#endif
}

/// Returns a ray from `from` to `from + range * direction`, with all bits of its mask set. [m]
inline RTCRay embree_ray(const Vec3f& from, const Vec3f& direction, float range) {
    RTCRay ray{};
    ray.org_x = from.x;
    ray.org_y = from.y;
    ray.org_z = from.z;
    ray.dir_x = direction.x;
    ray.dir_y = direction.y;
    ray.dir_z = direction.z;
    ray.tfar = range;
    ray.mask = ~0u;
    return ray;
}

/// Tests whether a ray hits anything that the filters of the scene accept.
inline bool meets_any(RTCScene scene, RTCRay ray) {
#if RTC_VERSION_MAJOR < 4
    RTCIntersectContext context = embree_context(Coherence::none);
    rtcOccluded1(scene, &context, &ray);
#else
    rtcOccluded1(scene, &ray);
#endif
    return ray.tfar < 0;  // Embree's mark of a hit
}

/// Returns the nearest hit of a ray, if there is one.
inline std::optional<RTCRayHit> nearest_hit(RTCScene scene, const RTCRay& ray) {
    RTCRayHit result{ray, {}};
    result.hit.geomID = result.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR < 4
    RTCIntersectContext context = embree_context(Coherence::none);
    rtcIntersect1(scene, &context, &result);
#else
    rtcIntersect1(scene, &result);
#endif
    if (result.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
    return result;
}

/// Returns the outward normal of the hit triangle in the frame of its mesh, of any length.
inline Vec3f outwards(const RTCRayHit& ray) {
    return Vec3f(ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z);
}

}  // namespace haarfield
