#include "fields/base/embree_device.h"

#include <gtest/gtest.h>
#include <sched.h>
#include <tbb/blocked_range.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>
#include <vector>

#include "fields/base/embree_rays.h"
#include "tests/fixtures/example_meshes.h"
#include "tests/fixtures/with_threads.h"

namespace haarfield {
namespace {

using OwnedScene = std::shared_ptr<RTCSceneTy>;

OwnedScene built_scene(const EmbreeDevice& device, const Mesh& mesh, RTCSceneFlags flags) {
    OwnedScene scene(rtcNewScene(device.get()), &rtcReleaseScene);
    rtcSetSceneFlags(scene.get(), flags);
    const std::shared_ptr<RTCGeometryTy> geometry = device.triangles(mesh.positions, mesh.triangles);
    rtcCommitGeometry(geometry.get());
    rtcAttachGeometry(scene.get(), geometry.get());
    device.commit(scene.get());
    return scene;
}

std::size_t usable_cores() {
    cpu_set_t cores;
    return sched_getaffinity(0, sizeof cores, &cores) == 0 ? std::size_t(CPU_COUNT(&cores)) : 0;
}

TEST(EmbreeDevice, LeavesTheNumberOfThreadsAndTheirCores) {
    const std::size_t cores = usable_cores();
    for (const std::size_t threads : {1u, 3u, 8u})
        with_threads(threads, [&] {
            const EmbreeDevice device;
            EXPECT_EQ(allowed_threads(), threads);
            const OwnedScene scene = built_scene(device, sphere_mesh({0, 0, 0}, 1, 60), RTC_SCENE_FLAG_NONE);
            EXPECT_EQ(allowed_threads(), threads);
            EXPECT_EQ(usable_cores(), cores);
        });
}

/// Bounds of unit cubes along a line. Pauses now and then, so that threads wait for each other in a build.
void slow_bounds(const RTCBoundsFunctionArguments* arguments) {
    if (arguments->primID % 256 == 0) std::this_thread::sleep_for(std::chrono::microseconds(100));
    const auto x = static_cast<float>(arguments->primID);
    *arguments->bounds_o = {x, 0, 0, 0, x + 1, 1, 1, 0};
}

OwnedScene slowly_built_scene(const EmbreeDevice& device) {
    OwnedScene scene(rtcNewScene(device.get()), &rtcReleaseScene);
    const std::shared_ptr<RTCGeometryTy> geometry(rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_USER),
                                                  &rtcReleaseGeometry);
    rtcSetGeometryUserPrimitiveCount(geometry.get(), 16384);
    rtcSetGeometryBoundsFunction(geometry.get(), &slow_bounds, nullptr);
    rtcCommitGeometry(geometry.get());
    rtcAttachGeometry(scene.get(), geometry.get());
    device.commit(scene.get());
    return scene;
}

TEST(EmbreeDevice, ThreadsThatBuildEnterNoOtherIterationOfTheEnclosingLoop) {
    std::atomic<int> entered_again = 0, built = 0;
    with_threads(8, [&] {
        const EmbreeDevice device;
        tbb::enumerable_thread_specific<bool> in_use(false);
        tbb::parallel_for(0, 24, [&](int) {
            bool& buffer_in_use = in_use.local();
            entered_again += buffer_in_use;
            buffer_in_use = true;
            built += slowly_built_scene(device) != nullptr;
            buffer_in_use = false;
        });
    });
    EXPECT_EQ(built, 24);
    EXPECT_EQ(entered_again, 0);
}

/// Every triangle three times, and squares that overlap in one plane.
Mesh mesh_with_equal_hits() {
    Mesh mesh = sphere_mesh({0, 0, 0}, 1, 80);
    for (const float side : {3.0f, 2.5f, 2.25f}) mesh = joined_meshes(mesh, square_mesh(side, 0.25f, 40));
    mesh = joined_meshes(mesh, joined_meshes(mesh, mesh));
    return mesh;
}

struct FoundHit {
    unsigned triangle = RTC_INVALID_GEOMETRY_ID;
    float u = 0, v = 0, distance = 0;
    bool operator==(const FoundHit&) const = default;
};

std::vector<FoundHit> hits(RTCScene scene) {
    std::vector<FoundHit> found(40000);
    for (std::size_t i = 0; i < found.size(); ++i) {
        const double z = 1 - (2 * double(i) + 1) / double(found.size()), azimuth = 2.399963 * double(i),
                     across = std::sqrt(1 - z * z);
        const Vec3f direction(float(across * std::cos(azimuth)), float(z), float(across * std::sin(azimuth)));
        const auto hit = nearest_hit(scene, embree_ray({0.1f, 0.6f, -0.2f}, direction, 100));
        if (hit) found[i] = {hit->hit.primID, hit->hit.u, hit->hit.v, hit->ray.tfar};
    }
    return found;
}

TEST(EmbreeDevice, EqualHitsDoNotDependOnTheNumberOfThreads) {
    const Mesh mesh = mesh_with_equal_hits();
    ASSERT_GT(mesh.triangles.size(), 50000u);
    for (const RTCSceneFlags flags : {RTC_SCENE_FLAG_NONE, RTC_SCENE_FLAG_ROBUST}) {
        std::vector<FoundHit> wanted;
        for (const std::size_t threads : {1u, 1u, 2u, 8u, 8u, 8u})
            with_threads(threads, [&] {
                const EmbreeDevice device;
                const std::vector<FoundHit> found = hits(built_scene(device, mesh, flags).get());
                if (wanted.empty()) wanted = found;
                EXPECT_TRUE(found == wanted) << threads << " threads, flags " << flags;
            });
    }
}

}  // namespace
}  // namespace haarfield
