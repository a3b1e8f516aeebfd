#include "shading/visibility/instanced_triangles.h"

#include <algorithm>
#include <cassert>

#include "fields/base/embree_rays.h"

namespace haarfield {
namespace {

std::shared_ptr<RTCSceneTy> new_scene(RTCDevice device) {
    std::shared_ptr<RTCSceneTy> scene(rtcNewScene(device), &rtcReleaseScene);
    // Without it, rays pass through edges shared by triangles.
    rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);
    return scene;
}

}  // namespace

unsigned instance_mask(std::size_t instance) {
    unsigned mask = 0;
    for (unsigned bit = 0; bit < 16; ++bit) mask |= 1u << (2 * bit + (instance >> bit & 1u));
    return mask;
}

void InstancedTriangles::add_entity(std::span<const Vec3f> positions,
                                    std::span<const std::array<std::uint32_t, 3>> triangles) {
    std::shared_ptr<RTCSceneTy> made = new_scene(device_.get());
    const std::shared_ptr<RTCGeometryTy> geometry = device_.triangles(positions, triangles);
    rtcSetGeometryMask(geometry.get(), ~0u);
    rtcCommitGeometry(geometry.get());
    rtcAttachGeometry(made.get(), geometry.get());
    device_.commit(made.get());
    entities_.push_back(std::move(made));
}

void InstancedTriangles::place(const ShadedScene& scene) {
    assert(scene.entities.size() == entities_.size());
    std::shared_ptr<RTCSceneTy> made = new_scene(device_.get());
    std::size_t number = 0;
    for (const ShadedInstance& instance : scene.instances) {
        const RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(geometry, entities_[instance.entity].get());
        const std::array<float, 12> columns = instance.placement.columns();
        rtcSetGeometryMask(geometry, instance_mask(number++));
        rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns.data());
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(made.get(), geometry);
        rtcReleaseGeometry(geometry);
    }
    device_.commit(made.get());
    scene_ = std::move(made);
}

std::optional<SurfacePlace> InstancedTriangles::nearest(const ShadedScene& scene, const Vec3f& from,
                                                        const Vec3f& direction) const {
    constexpr float relative_offset = 1e-4f;
    const std::optional<RTCRayHit> hit = nearest_hit(scene_.get(), embree_ray(from, direction, far_away));
    if (!hit) return std::nullopt;
    const std::size_t instance = hit->hit.instID[0];
    Vec3f normal = scene.instances[instance].placement.direction_to_world(outwards(*hit)).normalized();
    if (normal.dot(direction) > 0) normal = -normal;
    const float distance = hit->ray.tfar;
    return SurfacePlace{from + direction * distance + normal * (relative_offset * distance), normal,
                        instance};
}

}  // namespace haarfield
