#include "fields/base/embree_device.h"

#include <embree3/rtcore.h>

#include <atomic>

#include "fields/base/instruction_set.h"

namespace haarfield {

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

EmbreeDevice::EmbreeDevice(const char* settings)
    : state_(
          std::make_shared<State>(allocated<RTCDeviceTy>(rtcNewDevice(embree_settings(settings).c_str())))) {}

RTCDeviceTy* EmbreeDevice::get() const {
    return state_->device;
}

void EmbreeDevice::commit(RTCSceneTy* scene) const {
    rtcCommitScene(scene);
    if (state_->failed) throw std::bad_alloc();
}

}  // namespace haarfield
