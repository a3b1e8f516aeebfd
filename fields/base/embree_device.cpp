#include "fields/base/embree_device.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>

#include "fields/base/embree_rays.h"
#include "fields/base/instruction_set.h"

namespace haarfield {
namespace {

/// Casts to T*. Throws std::bad_alloc for null, which Embree returns if memory runs out.
template <class T>
T* allocated(void* memory) {
    if (!memory) throw std::bad_alloc();
    return static_cast<T*>(memory);
}

}  // namespace

struct EmbreeDevice::State {
    State(const State&) = delete;
    State& operator=(const State&) = delete;
    explicit State(RTCDevice made) : device(made) {
        rtcSetDeviceErrorFunction(
            device, [](void* flag, RTCError, const char*) { *static_cast<std::atomic<bool>*>(flag) = true; },
            &failed);
    }
    ~State() {
        if (!failed) {
            rtcReleaseDevice(device);
            return;
        }
        rtcSetDeviceErrorFunction(device, nullptr, nullptr);
    }

    RTCDevice device;
    std::atomic<bool> failed = false;
};

// Embree passes the setting `threads` to oneTBB as a limit of the whole process, for the device's lifetime.
EmbreeDevice::EmbreeDevice()
    : state_(std::make_shared<State>(allocated<RTCDeviceTy>(rtcNewDevice(embree_settings().c_str())))) {}

RTCDeviceTy* EmbreeDevice::get() const {
    return state_->device;
}

std::shared_ptr<RTCGeometryTy> EmbreeDevice::triangles(
    std::span<const Vec3f> positions, std::span<const std::array<std::uint32_t, 3>> triangles) const {
    std::shared_ptr<RTCGeometryTy> made(
        allocated<RTCGeometryTy>(rtcNewGeometry(state_->device, RTC_GEOMETRY_TYPE_TRIANGLE)),
        &rtcReleaseGeometry);
    if (triangles.empty()) return made;  // Embree returns null for an empty buffer, too
    auto* coordinates = allocated<float>(rtcSetNewGeometryBuffer(
        made.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), positions.size()));
    for (const Vec3f& p : positions)
        for (int axis = 0; axis < 3; ++axis) *coordinates++ = p[axis];
    auto* indices = allocated<std::uint32_t>(rtcSetNewGeometryBuffer(
        made.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), triangles.size()));
    for (const auto& triangle : triangles) indices = std::copy(triangle.begin(), triangle.end(), indices);
    return made;
}

void EmbreeDevice::commit(RTCSceneTy* scene) const {
    // Embree itself isolates its builds only if it was compiled for a recent oneTBB.
    tbb::this_task_arena::isolate([scene] { rtcCommitScene(scene); });
    if (state_->failed) throw std::bad_alloc();
}

}  // namespace haarfield
