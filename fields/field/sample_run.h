#pragma once
/// Serialised runs of a field's samples, passed from the process that computed them to the one that joins
/// them.

#include "fields/field/field_precompute.h"
#include "fields/file/section_file.h"

namespace haarfield {

/// Converts a run to sections of a file.
///
/// keys  of the field.
std::vector<Section> sample_sections(const SampleRun& run, const FieldKeys& keys);

/// The inverse of sample_sections.
///
/// errors  (with an empty `where`) samples of a field with other keys; a section is missing or has the wrong
///         size; a defect of the pool; a handle that is not in the pool.
Result<SampleRun> sections_samples(const std::vector<Section>& sections, const FieldKeys& keys);

}  // namespace haarfield
