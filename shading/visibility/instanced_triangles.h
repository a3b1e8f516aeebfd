#pragma once
/// The meshes and instances of a scene as Embree scenes, for all kinds of rays.

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "fields/base/embree_device.h"
#include "shading/scene/shaded_scene.h"

struct RTCSceneTy;

namespace haarfield {

/// Returns the ray mask of an instance. Each of the 16 lowest bits of its index selects one of two mask bits.
/// Masks of different indices therefore differ in some bit, and a ray with the complement of a mask hits all
/// instances except that one.
unsigned instance_mask(std::size_t instance);

/// A point of a surface, in the world.
struct SurfacePlace {
    Vec3f from;                ///< Off the surface. [m]
    Vec3f normal;              ///< Unit length.
    std::size_t instance = 0;  ///< That the surface belongs to.
};

/// The triangles of a scene's entities, and the Embree scene of its instances. Copies share what was built.
/// Threads may share it while nothing is added or placed.
class InstancedTriangles {
public:
    /// Adds an entity; entities are numbered in the order of their addition.
    ///
    /// cost  about 0.3 us per triangle.
    void add_entity(std::span<const Vec3f> positions,
                    std::span<const std::array<std::uint32_t, 3>> triangles);

    /// Builds the scene of the instances in their current placements. Entities must have been added in the
    /// scene's order.
    ///
    /// cost  2 us per instance.
    void place(const ShadedScene& scene);

    /// Returns the scene of the instances; geometry IDs are instance indices.
    RTCSceneTy* scene() const { return scene_.get(); }

    /// Returns the nearest surface that a ray in the world meets. The place is on the side from which the ray
    /// comes, off the surface by 1e-4 of the ray's length.
    ///
    /// scene  with the placements of the last call of `place`.
    std::optional<SurfacePlace> nearest(const ShadedScene& scene, const Vec3f& from,
                                        const Vec3f& direction) const;

private:
    EmbreeDevice device_;
    std::vector<std::shared_ptr<RTCSceneTy>> entities_;
    std::shared_ptr<RTCSceneTy> scene_;
};

/// Length of rays to distant light: Embree's packet queries may not return for infinite rays. [m]
inline constexpr float far_away = 1e8f;

}  // namespace haarfield
