#pragma once
/// Making a visibility field: rasterize, transform, truncate, pack.

#include <functional>
#include <optional>
#include <span>

#include "fields/base/progress.h"
#include "fields/base/result.h"
#include "fields/field/entity_occlusion.h"
#include "fields/field/visibility_field.h"
#include "fields/preparation/mesh_preparation.h"

namespace haarfield {

/// What a field of this mesh with these settings is called, and what depends on less in it.
FieldKeys field_keys(const PreparedMesh& mesh, const FieldSettings& settings);

/// Cubemaps of neighbouring samples of a field, which are numbered in the order planar, spherical, local.
struct SampleRun {
    std::uint64_t first = 0;            ///< Number of the first of them.
    std::vector<std::int32_t> handles;  ///< Of `pool`, one per sample.
    QuadtreePool pool;                  ///< Must be without defect.
};

/// Parts of a field that are there already.
struct KnownSamples {
    std::span<const SampleRun> runs{};  ///< By their first samples; they do not overlap.
    std::optional<FieldError> error{};  ///< Of fields with these surroundings.
};

/// The planar and spherical samples of a field, which are all that its FieldKeys::surroundings names.
SampleRun surrounding_samples(const VisibilityField& field);

/// How many samples the field of a mesh has.
std::uint64_t sample_count(const PreparedMesh& mesh, const FieldSettings& settings);

/// The samples from number `begin` up to, but not at, `end` of the field that precompute_field makes.
///
/// cost, errors  as there, of so many samples.
Result<SampleRun> field_samples(const std::string& entity, const PreparedMesh& mesh,
                                const EntityOcclusion& occlusion, const FieldSettings& settings,
                                std::uint64_t begin, std::uint64_t end, const Progress& progress = {});

/// The field of an entity; mesh and occlusion are of one entity. Uses all of oneTBB's threads; the result
/// does not depend on their number, nor on what was known: equal keys, equal fields, bit for bit.
///
/// known   of a field with the same keys, or its surroundings of one with the same surroundings.
/// cost    one rasterization and transform per planar, spherical and fine-mesh sample that is not known.
/// memory  the field, and a few hundred samples.
/// errors  interrupted; more than 2^31 samples, or 4 GiB of nodes.
Result<VisibilityField> precompute_field(std::string entity, const PreparedMesh& mesh,
                                         const EntityOcclusion& occlusion, const FieldSettings& settings,
                                         const Progress& progress = {}, const KnownSamples& known = {});

/// What is seen past an occluder from the samples of both samplers around it: a field without local samples,
/// key and error estimate.
///
/// is_inside  whether a point lies inside of what the occluder stands for, so that it sees nothing.
/// cost       one rasterization and transform per sample.
/// errors     as precompute_field.
Result<VisibilityField> precompute_surroundings(std::string entity, const Occluder& occluder,
                                                const std::function<bool(const Vec3f&)>& is_inside,
                                                const FieldSettings& settings, const Progress& progress = {});

}  // namespace haarfield
