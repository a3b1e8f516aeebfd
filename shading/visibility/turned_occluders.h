#pragma once
/// The occluders of a scene's instances in their rotations.

#include <memory>

#include "fields/base/progress.h"
#include "fields/base/result.h"
#include "shading/scene/shaded_scene.h"

namespace haarfield {

/// The occluders of an entity in a frame that differs from the world by translation and scale alone
/// (Placement::point_to_turned). Without a rotation these are the entity's occluders, otherwise rotated
/// copies.
class TurnedOccluders {
public:
    /// The entity's occluders must outlive it.
    TurnedOccluders(const EntityOcclusion& occlusion, const Rotation& rotation);
    TurnedOccluders(const TurnedOccluders&) = delete;
    TurnedOccluders& operator=(const TurnedOccluders&) = delete;

    const Occluder& coarse() const { return *coarse_; }  ///< See EntityOcclusion.
    const Occluder& own() const { return *own_; }        ///< See EntityOcclusion.

private:
    std::unique_ptr<const Occluder> turned_coarse_, turned_own_;  ///< Null: not rotated, or one occluder for
                                                                  ///< both.
    const Occluder *coarse_, *own_;
};

/// Occluders by instance of a scene; instances with equal rotations share them.
class InstanceOccluders {
public:
    /// Rotates the occluders.
    ///
    /// before  the result for an earlier state of the scene; rotations that still occur are reused.
    /// memory  about 150 bytes per triangle for each rotation of an entity.
    /// cost    about 1 ms per 5,000 triangles for each new rotation, in parallel on oneTBB.
    /// errors  interrupted.
    static Result<InstanceOccluders> make(const ShadedScene& scene, const InstanceOccluders* before = nullptr,
                                          const std::stop_token& stop = {});

    /// Returns the occluders of an instance.
    const TurnedOccluders& operator[](std::size_t instance) const { return *occluders_[instance]; }

private:
    /// Identifies a rotated copy.
    struct Key {
        const EntityOcclusion* occlusion;
        Rotation rotation;

        bool operator<(const Key& other) const;
    };

    std::vector<std::shared_ptr<const TurnedOccluders>> occluders_;
    std::vector<Key> keys_;  ///< By instance.
};

}  // namespace haarfield
