#include "shading/visibility/light_filters.h"

#include <cassert>
#include <cmath>

#include "fields/base/embree_rays.h"

namespace haarfield {

void LightFilters::add(std::span<const Vec3f> positions,
                       std::span<const std::array<std::uint32_t, 3>> triangles, std::vector<Rgb> colours,
                       const Rgb& absorption) {
    assert(colours.size() == 1 || colours.size() == triangles.size());
    if (!scene_) {
        scene_.reset(rtcNewScene(device_.get()), &rtcReleaseScene);
        rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
    }
    const std::shared_ptr<RTCGeometryTy> geometry = device_.triangles(positions, triangles);
    rtcSetGeometryMask(geometry.get(), ~0u);
    rtcCommitGeometry(geometry.get());
    rtcAttachGeometryByID(scene_.get(), geometry.get(), static_cast<unsigned>(colours_.size()));
    colours_.push_back(std::move(colours));
    absorption_.push_back(absorption);
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
    const Vec3f way = end - from;
    const float length = way.length();
    RTCRay ray = embree_ray(from, way, 1);
    unsigned last_geometry = RTC_INVALID_GEOMETRY_ID;
    bool last_enters = false;
    float last = 0;
    for (int crossing = 0; crossing < most && passed != Rgb(0.0f); ++crossing) {
        const std::optional<RTCRayHit> hit = nearest_hit(scene_.get(), ray);
        if (!hit) break;
        const float at = hit->ray.tfar;
        const unsigned geometry = hit->hit.geomID;
        const bool is_same = geometry == last_geometry, enters = outwards(*hit).dot(way) < 0;
        // At an edge, rounding can find both triangles. A ray enters and leaves a surface in turn.
        if (!is_same || enters != last_enters || at - last > again * at) {
            const std::vector<Rgb>& colours = colours_[geometry];
            passed *= colours[colours.size() > 1 ? hit->hit.primID : 0];
        }
        if (crossing > 0 && !enters)
            for (int c = 0; c < 3; ++c)
                passed[c] *= std::exp(-absorption_[geometry][c] * (at - last) * length);
        last_geometry = geometry;
        last_enters = enters;
        last = at;
        ray.tnear = at * (1 + past);
    }
    return passed;
}

}  // namespace haarfield
