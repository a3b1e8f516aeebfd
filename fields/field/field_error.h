#pragma once
/// How far the visibility that is looked up in a field is from what would be seen.

#include <stop_token>

#include "fields/field/entity_occlusion.h"
#include "fields/field/visibility_field.h"

namespace haarfield {

/// Measured at 40 random points of each band on the ground plane, and as many around the entity, those
/// inside of it left out. All errors of the field take part: interpolation, truncation and rounding.
///
/// field  as precompute_field makes it, of the same mesh as `occlusion`.
/// stop   when it is requested, returns soon, and the result is of no use.
/// cost   1,280 rasterizations and lookups, on all of oneTBB's threads; the result does not depend on their
///        number.
FieldError field_error(const VisibilityField& field, const EntityOcclusion& occlusion,
                       const std::stop_token& stop = {});

}  // namespace haarfield
