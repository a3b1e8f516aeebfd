#pragma once
/// The error of visibility that is interpolated from a field.

#include <stop_token>

#include "fields/field/entity_occlusion.h"
#include "fields/field/visibility_field.h"

namespace haarfield {

/// Measures the error at 40 random points of each band on the ground plane and as many around the entity,
/// except points inside it. Includes all errors of the field: interpolation, truncation and rounding.
///
/// field  as computed by precompute_field, for the same mesh as `occlusion`.
/// stop   after a stop request, returns soon with an unusable result.
/// cost   1,280 rasterizations and lookups, in parallel on oneTBB. The result does not depend on the number
///        of threads.
FieldError field_error(const VisibilityField& field, const EntityOcclusion& occlusion,
                       const std::stop_token& stop = {});

}  // namespace haarfield
