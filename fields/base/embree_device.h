#pragma once
/// Embree's device and objects where there is little memory: exceptions instead of rays that meet nothing.

#include <memory>
#include <new>

struct RTCDeviceTy;
struct RTCSceneTy;

namespace haarfield {

/// The same as a T; std::bad_alloc if it is null, as Embree's buffers are when there is no memory.
template <class T>
T* allocated(void* memory) {
    if (!memory) throw std::bad_alloc();
    return static_cast<T*>(memory);
}

/// One of Embree's devices. Copies share it, and the last releases it, unless memory ran out in a commit:
/// Embree then waits endlessly in the release, so that the device stays until the process ends.
class EmbreeDevice {
public:
    /// A device for the instructions that were chosen, with settings of its own (`threads=1`).
    ///
    /// throws  std::bad_alloc without memory for one.
    explicit EmbreeDevice(const char* settings);

    RTCDeviceTy* get() const;

    /// Makes a scene ready for rays.
    ///
    /// throws  std::bad_alloc where it needs more memory than there is.
    void commit(RTCSceneTy* scene) const;

private:
    struct State;
    std::shared_ptr<State> state_;
};

}  // namespace haarfield
