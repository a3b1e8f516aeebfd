#pragma once
/// Computation of a visibility field: rasterize, transform, truncate, pack.

#include <functional>
#include <optional>
#include <span>

#include "fields/base/progress.h"
#include "fields/base/result.h"
#include "fields/field/entity_occlusion.h"
#include "fields/field/visibility_field.h"
#include "fields/preparation/mesh_preparation.h"

namespace haarfield {

/// Returns the keys that identify the field of this mesh with these settings, and its surroundings.
FieldKeys field_keys(const PreparedMesh& mesh, const FieldSettings& settings);

/// Cubemaps of consecutive samples of a field, which are numbered in the order planar, spherical, local.
struct SampleRun {
    std::uint64_t first = 0;            ///< Number of the first sample.
    std::vector<std::int32_t> handles;  ///< Handles in `pool`, one per sample.
    QuadtreePool pool;                  ///< Must have no defect.
};

/// Precomputed samples and errors of a field.
struct PrecomputedSamples {
    std::span<const SampleRun> runs{};  ///< Sorted by first sample, without overlap.
    std::optional<FieldError> error{};  ///< The error of fields with these surroundings.
};

/// Returns the planar and spherical samples of a field: all that FieldKeys::surroundings covers.
SampleRun surrounding_samples(const VisibilityField& field);

/// Returns the number of samples of the field of a mesh.
std::uint64_t sample_count(const PreparedMesh& mesh, const FieldSettings& settings);

/// Computes the samples [begin, end) of the field that precompute_field makes.
///
/// cost, errors  those of precompute_field for this number of samples.
Result<SampleRun> field_samples(const std::string& entity, const PreparedMesh& mesh,
                                const EntityOcclusion& occlusion, const FieldSettings& settings,
                                std::uint64_t begin, std::uint64_t end, const Progress& progress = {});

/// Computes the field of an entity. `mesh` and `occlusion` belong to the same entity. Runs in parallel on
/// oneTBB. The result depends neither on the number of threads nor on `known`: fields with equal keys are
/// bit-identical.
///
/// known   samples of a field with the same keys, or surroundings of one with the same surroundings.
/// cost    one rasterization and transform per planar, spherical and fine-mesh sample that is not known.
/// memory  the field, and a few hundred samples.
/// errors  interrupted; more than 2^31 samples, or nearly 2^32 distinct faces.
Result<VisibilityField> precompute_field(std::string entity, const PreparedMesh& mesh,
                                         const EntityOcclusion& occlusion, const FieldSettings& settings,
                                         const Progress& progress = {}, const PrecomputedSamples& known = {});

/// Returns the keys of a field without local samples: with the surroundings of field_keys.
FieldKeys surroundings_keys(const PreparedMesh& mesh, const FieldSettings& settings);

/// Computes the field of an entity without local samples; otherwise as precompute_field.
///
/// known  surroundings of a field with the same ones.
Result<VisibilityField> precompute_surroundings(std::string entity, const PreparedMesh& mesh,
                                                const EntityOcclusion& occlusion,
                                                const FieldSettings& settings, const Progress& progress = {},
                                                const PrecomputedSamples& known = {});

/// Returns the field of an entity without samples: for scenes in which it is always evaluated exactly.
VisibilityField empty_field(std::string entity, const PreparedMesh& mesh, const FieldSettings& settings);

/// Samples the visibility around an occluder with both samplers: a field without local samples, keys and
/// error estimate.
///
/// is_inside  true for points inside the represented object, at which all directions are blocked.
/// cost       one rasterization and transform per sample.
/// errors     those of precompute_field.
Result<VisibilityField> precompute_surroundings(std::string entity, const Occluder& occluder,
                                                const std::function<bool(const Vec3f&)>& is_inside,
                                                const FieldSettings& settings, const Progress& progress = {});

}  // namespace haarfield
