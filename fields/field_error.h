#pragma once
/// How far the visibility that is looked up in a field is from what would be seen.

#include "fields/entity_occlusion.h"
#include "fields/visibility_field.h"

namespace haarfield {

/// Measured at 200 random points on the ground plane and 200 around the entity, outside of it and at most
/// three bounding radii from the samplers' centres, near ones as likely as far ones. All errors of the field
/// take part: interpolation, truncation and rounding.
///
/// field      as precompute_field makes it, of the same mesh as `occlusion`.
/// cost       400 rasterizations and lookups, on all of oneTBB's threads; the result does not depend on their
///            number.
FieldError field_error(const VisibilityField& field, const EntityOcclusion& occlusion);

}  // namespace haarfield
