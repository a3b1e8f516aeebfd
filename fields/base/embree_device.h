#pragma once
/// Embree's device and geometries. If memory runs out, an exception is thrown instead of rays missing
/// geometry.

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

/// An Embree device. Copies share it, and the last copy releases it. If memory ran out in a commit, the
/// device is never released, because Embree would wait forever in the release.
///
/// A device limits neither the number of oneTBB's threads nor their affinity.
class EmbreeDevice {
public:
    /// Creates a device for the chosen instruction set.
    ///
    /// throws  std::bad_alloc if memory runs out.
    EmbreeDevice();

    RTCDeviceTy* get() const;  ///< Embree's device.

    /// Returns triangles for a scene of this device. They are not committed, so filters and masks can still
    /// be set.
    ///
    /// positions  in metres; copied
    /// triangles  indices into positions; copied
    /// throws     std::bad_alloc if memory runs out.
    std::shared_ptr<RTCGeometryTy> triangles(std::span<const Vec3f> positions,
                                             std::span<const std::array<std::uint32_t, 3>> triangles) const;

    /// Builds a scene's BVH, in parallel on oneTBB. The calling thread executes no other tasks meanwhile, so
    /// a loop body may call this function while it uses its thread's buffers or holds a lock. The BVH does
    /// not depend on the number of threads.
    ///
    /// throws  std::bad_alloc if memory runs out.
    void commit(RTCSceneTy* scene) const;

private:
    struct State;
    std::shared_ptr<State> state_;
};

}  // namespace haarfield
