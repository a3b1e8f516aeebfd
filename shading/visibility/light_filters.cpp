#include "shading/visibility/light_filters.h"

#include <cassert>

#include "fields/base/embree_rays.h"

namespace haarfield {

void LightFilters::add(std::span<const Vec3f> positions,
                       std::span<const std::array<std::uint32_t, 3>> triangles, const Rgb& colour) {
    if (!scene_) {
        scene_.reset(rtcNewScene(device_.get()), &rtcReleaseScene);
        rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
    }
    const std::shared_ptr<RTCGeometryTy> geometry = device_.triangles(positions, triangles);
    rtcSetGeometryMask(geometry.get(), ~0u);
    rtcCommitGeometry(geometry.get());
    rtcAttachGeometryByID(scene_.get(), geometry.get(), static_cast<unsigned>(colours_.size()));
    colours_.push_back(colour);
}

void LightFilters::commit() {
    if (scene_) device_.commit(scene_.get());
}

Rgb LightFilters::transmitted(const Vec3f& from, const Vec3f& end) const {
    constexpr int most = 256;       // Crossings of one ray.
    constexpr float past = 2e-6f;   // Of the way to a crossing.
    constexpr float again = 1e-4f;  // Of that way.
    Rgb passed(1.0f);
    if (!scene_) return passed;
    RTCRay ray = embree_ray(from, end - from, 1);
    unsigned geometry = RTC_INVALID_GEOMETRY_ID;
    bool enters = false;
    float last = 0;
    for (int crossing = 0; crossing < most && passed != Rgb(0.0f); ++crossing) {
        const std::optional<RTCRayHit> hit = nearest_hit(scene_.get(), ray);
        if (!hit) break;
        const float at = hit->ray.tfar;
        const bool enters_here = outwards(*hit).dot(end - from) < 0;
        // At an edge, rounding can find both triangles. A ray enters and leaves a surface in turn.
        if (hit->hit.geomID != geometry || enters_here != enters || at - last > again * at)
            passed *= colours_[hit->hit.geomID];
        geometry = hit->hit.geomID;
        enters = enters_here;
        last = at;
        ray.tnear = at * (1 + past);
    }
    return passed;
}

}  // namespace haarfield
