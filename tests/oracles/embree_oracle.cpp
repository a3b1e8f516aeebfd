#include "tests/oracles/embree_oracle.h"

#include <cmath>
#include <cstring>

#include "fields/base/embree_rays.h"
#include "fields/rasterizer/visibility_rasterizer.h"

namespace haarfield {

const FaceFrame face_frames[6] = {
    {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}},  {{-1, 0, 0}, {0, 0, -1}, {0, -1, 0}},
    {{0, 1, 0}, {1, 0, 0}, {0, 0, -1}},  {{0, -1, 0}, {1, 0, 0}, {0, 0, 1}},
    {{0, 0, 1}, {-1, 0, 0}, {0, -1, 0}}, {{0, 0, -1}, {1, 0, 0}, {0, -1, 0}},
};

Vec3d sub_sample_direction(int face, int column, int row, int sub_sample, int face_size) {
    const double u = 2 * (column + sample_offset(sub_sample)) / face_size - 1;
    const double v = 2 * (row + (sub_sample + 0.5) / samples_per_texel) / face_size - 1;
    const FaceFrame& frame = face_frames[face];
    return frame.axis + frame.right * u + frame.down * v;
}

EmbreeOracle::EmbreeOracle(const Occluder& occluder, const char* device_settings) {
    const RTCDevice device = rtcNewDevice(device_settings);
    const RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    const RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    void* vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                             sizeof(Vec3f), occluder.positions().size());
    void* triangles = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                              3 * sizeof(std::uint32_t), occluder.triangles().size());
    std::memcpy(vertices, occluder.positions().data(), occluder.positions().size() * sizeof(Vec3f));
    std::memcpy(triangles, occluder.triangles().data(),
                occluder.triangles().size() * 3 * sizeof(std::uint32_t));
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    scene_ = std::shared_ptr<void>(scene, [device](void* owned) {
        rtcReleaseScene(static_cast<RTCScene>(owned));
        rtcReleaseDevice(device);
    });
}

bool EmbreeOracle::is_open(const Vec3f& origin, const Vec3d& direction) const {
    return !meets_any(static_cast<RTCScene>(scene_.get()), embree_ray(origin, Vec3f(direction), INFINITY));
}

std::vector<std::uint8_t> EmbreeOracle::open_samples(const Vec3f& view_point, int face_size) const {
    std::vector<std::uint8_t> open;
    for (int face = 0; face < 6; ++face)
        for (int row = 0; row < face_size; ++row)
            for (int column = 0; column < face_size; ++column) {
                int count = 0;
                for (int s = 0; s < samples_per_texel; ++s)
                    count += is_open(view_point, sub_sample_direction(face, column, row, s, face_size));
                open.push_back(static_cast<std::uint8_t>(count));
            }
    return open;
}

}  // namespace haarfield
