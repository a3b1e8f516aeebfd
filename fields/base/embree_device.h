#pragma once
/// Embree's device and objects where there is little memory: exceptions instead of rays that meet nothing.

#include <array>
#include <cstdint>
#include <memory>
#include <new>
#include <span>

#include "fields/base/vector.h"

struct RTCDeviceTy;
struct RTCGeometryTy;
struct RTCSceneTy;

namespace haarfield {

/// One of Embree's devices. Copies share it, and the last releases it, unless memory ran out in a commit:
/// Embree then waits endlessly in the release, so that the device stays until the process ends.
///
/// A device limits neither the number of oneTBB's threads nor their affinity.
class EmbreeDevice {
public:
    /// A device for the chosen instruction set.
    ///
    /// throws  std::bad_alloc without memory for one.
    EmbreeDevice();

    RTCDeviceTy* get() const;

    /// Triangles for one of its scenes, not committed yet: filters and masks may still be set.
    ///
    /// positions  in metres; copied
    /// triangles  indices into positions; copied
    /// throws     std::bad_alloc without memory for them.
    std::shared_ptr<RTCGeometryTy> triangles(std::span<const Vec3f> positions,
                                             std::span<const std::array<std::uint32_t, 3>> triangles) const;

    /// Builds a scene's BVH, in parallel on oneTBB. The calling thread executes no other tasks meanwhile, so
    /// a loop body may call this function while it uses its thread's buffers or holds a lock. The BVH does
    /// not depend on the number of threads.
    ///
    /// throws  std::bad_alloc where it needs more memory than there is.
    void commit(RTCSceneTy* scene) const;

private:
    struct State;
    std::shared_ptr<State> state_;
};

}  // namespace haarfield
