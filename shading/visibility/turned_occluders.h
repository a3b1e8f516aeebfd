#pragma once
/// What the instances of a scene hide, turned as they are.

#include <memory>

#include "fields/base/progress.h"
#include "fields/base/result.h"
#include "shading/scene/shaded_scene.h"

namespace haarfield {

/// The occluders of an entity in a frame that differs from the world's by translation and scale alone
/// (Placement::point_to_turned): the entity's own if nothing is turned, else turned copies of them.
class TurnedOccluders {
public:
    TurnedOccluders(const EntityOcclusion& occlusion, const Rotation& rotation);
    TurnedOccluders(const TurnedOccluders&) = delete;
    TurnedOccluders& operator=(const TurnedOccluders&) = delete;

    /// See EntityOcclusion.
    const Occluder& coarse() const { return *coarse_; }
    const Occluder& own() const { return *own_; }

private:
    std::unique_ptr<const Occluder> turned_coarse_, turned_own_;  ///< Null: not turned, or one for both.
    const Occluder *coarse_, *own_;
};

/// By instance of a scene; those that are turned alike share theirs.
class InstanceOccluders {
public:
    /// before  what was made for the scene as it was: what still fits is taken from there.
    /// memory  of each rotation of an entity, some 150 bytes a triangle.
    /// cost    of each that is new, some 1 ms per 5,000 triangles; on all of oneTBB's threads.
    /// errors  interrupted.
    static Result<InstanceOccluders> make(const ShadedScene& scene, const InstanceOccluders* before = nullptr,
                                          const std::stop_token& stop = {});

    const TurnedOccluders& operator[](std::size_t instance) const { return *occluders_[instance]; }

private:
    /// What decides occluders.
    struct Key {
        const EntityOcclusion* occlusion;
        Rotation rotation;

        bool operator<(const Key& other) const;
    };

    std::vector<std::shared_ptr<const TurnedOccluders>> occluders_;
    std::vector<Key> keys_;  ///< By instance.
};

}  // namespace haarfield
