#pragma once
/// The visibility field of one entity: what can be seen past it, around it and on its surface.

#include "fields/field/samplers.h"
#include "fields/mesh/mesh.h"
#include "fields/wavelets/quadtree_pool.h"

#include <string>

namespace haarfield {

/// 128 bits of XXH3.
struct ContentHash {
    std::uint64_t low = 0, high = 0;

    bool operator==(const ContentHash&) const = default;  ///< Equal in all bits.
    std::string hex() const;                              ///< 32 digits, high half first.
};

/// What fields are called: equal keys, equal fields, bit for bit.
struct FieldKeys {
    /// Of all that planar and spherical samples depend on: coarse mesh, what is inside, settings, format.
    ContentHash surroundings;
    ContentHash whole;  ///< Of that and the fine mesh, with its local samples.

    bool operator==(const FieldKeys&) const = default;  ///< Equal in all bits.
};

/// What decides a field, beside the mesh.
struct FieldSettings {
    std::int32_t face_size = 64;     ///< Texels along a cubemap edge: 16, 32, 64, 128 or 256.
    std::int32_t coefficients = 0;   ///< At most so many wavelets a face; 0: no limit.
    float relative_l2_error = 0.1f;  ///< Of the wavelets that are dropped, to the smaller of what is open and
                                     ///< blocked; 0: none are dropped. See VisibilityTransform.
    std::uint32_t planar_samples = 20000;
    std::uint32_t spherical_samples = 10000;

    bool operator==(const FieldSettings&) const = default;  ///< Equal in all bits.
};

/// The error of visibility that is looked up between a sampler's samples: RMS over points and all directions.
/// See field_error().
struct SamplerError {
    static constexpr std::size_t bands = 16;

    float relative = 0;  ///< To the RMS of the occlusion (1 - visibility) that is really there.
    /// In each sixteenth of the radial position (samplers.h), by itself, to the RMS of the visibility that is
    /// really there: inside a room, where little is open, a small error is large. In [0, 1]; 1 where nothing
    /// could be measured, or nothing is open.
    std::array<float, bands> band{};

    bool operator==(const SamplerError&) const = default;  ///< Equal in all bits.
};

/// The errors of both samplers.
struct FieldError {
    SamplerError planar, spherical;

    bool operator==(const FieldError&) const = default;  ///< Equal in all bits.
};

/// Handles of cubemaps in a pool, by sample of each sampler and by vertex of the fine mesh.
///
/// Visibility is 1 where a direction is open, 0 where the entity blocks it, and between on a texel that
/// it covers in part. Planar and spherical samples see the whole coarse mesh. Local samples see it from
/// the vertex; texels below the vertex's horizon hold nothing to rely on and must be multiplied by zero.
struct VisibilityField {
    std::string entity;
    FieldKeys keys;
    FieldSettings settings;
    Bounds bounds;  ///< Of the mesh. [m]
    PlanarSampler planar;
    SphericalSampler spherical;
    std::vector<std::int32_t> planar_handles;     ///< One per sample of `planar`.
    std::vector<std::int32_t> spherical_handles;  ///< One per sample of `spherical`.
    std::vector<std::int32_t> local_handles;      ///< One per vertex of the fine mesh.
    QuadtreePool pool;
    FieldError error;
};

/// What the planar sampler's positions are raised by where visibility is sampled: just above the ground, lest
/// what stands on it be seen edge-on. [m]
Vec3f planar_lift(const VisibilityField& field);

/// A cubemap interpolated from a field, face by face: open where nothing blocks.
CubemapTree interpolated_visibility(const VisibilityField& field, const std::vector<std::int32_t>& handles,
                                    const Interpolation& interpolation);

/// Whether a handle or face index is out of range, a table has the wrong length, or the pool has a
/// defect (pool_defect). Empty if all is well; otherwise what is wrong.
std::string field_defect(const VisibilityField& field);

}  // namespace haarfield
