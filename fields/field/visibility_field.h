#pragma once
/// The visibility field of an entity: visibility around the entity and on its surface.

#include "fields/field/samplers.h"
#include "fields/mesh/mesh.h"
#include "fields/wavelets/quadtree_pool.h"

#include <string>
#include <string_view>

namespace haarfield {

/// A 128 bit XXH3 hash.
struct ContentHash {
    std::uint64_t low = 0, high = 0;

    bool operator==(const ContentHash&) const = default;  ///< Exact comparison.
    std::string hex() const;                              ///< 32 digits, high half first.
};

ContentHash content_hash(std::string_view bytes);  ///< Returns the hash of the bytes.

/// The identity of a field: fields with equal keys are bit-identical.
struct FieldKeys {
    /// Covers everything that planar and spherical samples depend on: coarse and original mesh, bounds,
    /// settings, format.
    ContentHash surroundings;
    ContentHash whole;  ///< Covers the surroundings and the fine mesh with its local samples.

    bool operator==(const FieldKeys&) const = default;  ///< Exact comparison.
};

/// The parameters of a field besides the mesh.
struct FieldSettings {
    std::int32_t face_size = 64;    ///< Texels along a cubemap edge: 16, 32, 64, 128 or 256.
    std::int32_t coefficients = 0;  ///< At most this number of wavelets per face; 0: no limit.
    /// L2 error of truncation, relative to the smaller of visibility and occlusion; 0: keep all wavelets. See
    /// VisibilityTransform.
    float relative_l2_error = 0.1f;
    std::uint32_t planar_samples = 20000;
    std::uint32_t spherical_samples = 10000;

    bool operator==(const FieldSettings&) const = default;  ///< Exact comparison.
};

/// The RMS error of visibility interpolated between a sampler's samples, over points and all directions. See
/// field_error().
struct SamplerError {
    static constexpr std::size_t bands = 16;

    float relative = 0;  ///< Relative to the RMS of the exact occlusion (1 - visibility).
    /// The error in each sixteenth of the radial position (samplers.h), relative to the RMS of the exact
    /// visibility: inside a room, where visibility is low, a small error is large. In [0, 1]; 1 if nothing
    /// could be measured, or no direction is unoccluded.
    std::array<float, bands> band{};

    bool operator==(const SamplerError&) const = default;  ///< Exact comparison.
};

/// The errors of both samplers.
struct FieldError {
    SamplerError planar, spherical;

    bool operator==(const FieldError&) const = default;  ///< Exact comparison.
};

/// The visibility field of an entity: handles of cubemaps in a pool, for each sample of both samplers and
/// each vertex of the fine mesh. A field without local samples, or without any, serves bakes that sample
/// visibility at the vertices themselves.
///
/// Visibility is 1 if a direction is unoccluded, 0 if the entity blocks it, and in between on a partly
/// covered texel. Planar and spherical samples are taken around the coarse mesh, local samples around
/// EntityOcclusion::own at the vertices. Texels below a vertex's horizon are undefined and must be multiplied
/// by zero.
struct VisibilityField {
    std::string entity;
    FieldKeys keys;
    FieldSettings settings;
    Bounds bounds;  ///< Bounds of the mesh. [m]
    PlanarSampler planar;
    SphericalSampler spherical;
    std::vector<std::int32_t> planar_handles;     ///< One per sample of `planar`.
    std::vector<std::int32_t> spherical_handles;  ///< One per sample of `spherical`.
    std::vector<std::int32_t> local_handles;      ///< One per vertex of the fine mesh; or none.
    QuadtreePool pool;
    FieldError error;

    /// True if the field has samples around the entity.
    bool has_surroundings() const { return !spherical_handles.empty(); }
};

/// Returns the offset of the planar samples above the sampler's plane, so that surfaces on the ground are not
/// viewed edge-on. [m]
Vec3f planar_lift(const VisibilityField& field);

/// Interpolates a cubemap of a field, face by face.
CubemapTree interpolated_visibility(const VisibilityField& field, const std::vector<std::int32_t>& handles,
                                    const Interpolation& interpolation);

/// Checks a field: handles, face indices, the lengths of tables, the pool (pool_defect). Returns the first
/// defect, or an empty string.
std::string field_defect(const VisibilityField& field);

}  // namespace haarfield
