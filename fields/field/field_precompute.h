#pragma once
/// Making a visibility field: rasterize, transform, truncate, pack.

#include <functional>

#include "fields/base/progress.h"
#include "fields/base/result.h"
#include "fields/field/entity_occlusion.h"
#include "fields/field/visibility_field.h"
#include "fields/mesh/mesh_preparation.h"

namespace haarfield {

/// What the field of this mesh with these settings is called: equal keys, equal fields, bit for bit.
ContentHash field_key(const PreparedMesh& mesh, const FieldSettings& settings);

/// The field of an entity; mesh and occlusion are of one entity. Uses all of oneTBB's threads; the result
/// does not depend on their number.
///
/// cost    one rasterization and transform per planar, spherical and fine-mesh sample.
/// memory  the field, and a few hundred samples.
/// errors  interrupted; more than 2^31 samples, or 4 GiB of nodes.
Result<VisibilityField> precompute_field(std::string entity, const PreparedMesh& mesh,
                                         const EntityOcclusion& occlusion, const FieldSettings& settings,
                                         const Progress& progress = {});

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
