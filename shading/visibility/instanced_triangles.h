#pragma once
/// Meshes and where they stand, as Embree has them: what rays of all kinds are shot at.

#include <memory>
#include <span>
#include <vector>

#include "fields/base/embree_device.h"
#include "shading/scene/shaded_scene.h"

struct RTCSceneTy;

namespace haarfield {

/// What rays see of an instance: of each of its number's 16 lowest bits, one bit of the mask says that it
/// is set, another that it is not. A ray sees what its mask shares a bit with; the numbers of all others
/// differ in some bit, so that a ray with the mask's complement sees all but this one.
unsigned instance_mask(std::size_t instance);

/// Triangles of a scene's entities, and the scene of its instances. Copies share what was built. Safe to
/// share between threads while nothing is added or placed.
class InstancedTriangles {
public:
    /// One more entity: its number is that of those before.
    ///
    /// cost  some 0.3 us a triangle.
    void add_entity(std::span<const Vec3f> positions,
                    std::span<const std::array<std::uint32_t, 3>> triangles);

    /// The instances as they stand now: of entities that were added in the scene's order.
    ///
    /// cost  2 us each.
    void place(const ShadedScene& scene);

    RTCSceneTy* scene() const {
        return scene_.get();
    }  ///< Of the instances; their geometries' numbers are theirs.
    RTCSceneTy* entity(std::size_t e) const {
        return entities_[e].get();
    }  ///< Of one entity, in its own frame.

private:
    EmbreeDevice device_;
    std::vector<std::shared_ptr<RTCSceneTy>> entities_;
    std::shared_ptr<RTCSceneTy> scene_;
};

/// Rays end here: of infinite ones Embree's packets do not always come back. [m]
inline constexpr float far_away = 1e8f;

}  // namespace haarfield
