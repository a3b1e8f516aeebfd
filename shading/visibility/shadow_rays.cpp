#include "shading/visibility/shadow_rays.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cassert>

#include "fields/base/instruction_set.h"

namespace haarfield {
namespace {

/// Rays end here: of infinite ones Embree's packets do not always come back. [m]
constexpr float far_away = 1e8f;

std::shared_ptr<RTCSceneTy> new_scene(RTCDevice device) {
    std::shared_ptr<RTCSceneTy> scene(rtcNewScene(device), &rtcReleaseScene);
    // Without it rays slip through the edges that triangles share.
    rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);
    return scene;
}

}  // namespace

// Embree builds with its own threads, unless told: oneTBB's are enough to do one entity each.
ShadowRays::ShadowRays()
    : device_(rtcNewDevice(embree_settings("threads=1,set_affinity=0").c_str()), &rtcReleaseDevice) {}

void ShadowRays::build(const ShadedScene& scene) {
    entities_.clear();
    for (const ShadedEntity& entity : scene.entities) add_entity(entity);
    place(scene);
}

void ShadowRays::add_entity(const ShadedEntity& entity) {
    const Occluder& original = entity.occlusion->original();
    std::shared_ptr<RTCSceneTy> made = new_scene(device_.get());
    const RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* coordinates =
        static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                    3 * sizeof(float), original.positions().size()));
    for (const Vec3f& p : original.positions())
        for (int axis = 0; axis < 3; ++axis) *coordinates++ = p[axis];
    auto* indices = static_cast<std::uint32_t*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(std::uint32_t), original.triangles().size()));
    for (const auto& triangle : original.triangles())
        indices = std::copy(triangle.begin(), triangle.end(), indices);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(made.get(), geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(made.get());
    entities_.push_back(std::move(made));
}

void ShadowRays::place(const ShadedScene& scene) {
    assert(scene.entities.size() == entities_.size());
    std::shared_ptr<RTCSceneTy> made = new_scene(device_.get());
    for (const ShadedInstance& instance : scene.instances) {
        const RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(geometry, entities_[instance.entity].get());
        const std::array<float, 12> columns = instance.placement.columns();
        rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns.data());
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(made.get(), geometry);
        rtcReleaseGeometry(geometry);
    }
    rtcCommitScene(made.get());
    scene_ = std::move(made);
}

std::uint16_t ShadowRays::blocked(std::span<const Vec3f> points, std::uint16_t wanted,
                                  const Vec3f& direction) const {
    assert(points.size() <= packet);
    if (wanted == 0) return 0;
    RTCRay16 rays;
    alignas(64) std::array<int, packet> valid;
    for (std::size_t i = 0; i < packet; ++i) {
        const bool matters = i < points.size() && (wanted >> i & 1u) != 0;
        const Vec3f from = matters ? points[i] : Vec3f(0.0f);
        valid[i] = matters ? -1 : 0;
        rays.org_x[i] = from.x;
        rays.org_y[i] = from.y;
        rays.org_z[i] = from.z;
        rays.dir_x[i] = direction.x;
        rays.dir_y[i] = direction.y;
        rays.dir_z[i] = direction.z;
        rays.tnear[i] = 0;
        rays.tfar[i] = far_away;
        rays.time[i] = 0;
        rays.mask[i] = ~0u;
        rays.id[i] = 0;
        rays.flags[i] = 0;
    }
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    // Not flagged as coherent: with that, packets do not always come back from robust scenes of instances.
    rtcOccluded16(valid.data(), scene_.get(), &context, &rays);
    std::uint16_t result = 0;
    for (std::size_t i = 0; i < packet; ++i)
        if (valid[i] != 0 && rays.tfar[i] < 0) result = static_cast<std::uint16_t>(result | 1u << i);
    return result;
}

bool ShadowRays::is_blocked(const Vec3f& point, const Vec3f& direction) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRay ray{};
    ray.org_x = point.x;
    ray.org_y = point.y;
    ray.org_z = point.z;
    ray.dir_x = direction.x;
    ray.dir_y = direction.y;
    ray.dir_z = direction.z;
    ray.tfar = far_away;
    ray.mask = ~0u;
    rtcOccluded1(scene_.get(), &context, &ray);
    return ray.tfar < 0;  // Embree's mark of a hit
}

}  // namespace haarfield
