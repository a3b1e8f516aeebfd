#pragma once
/// Runs of a field's samples, on their way from the process that made them to the one that joins them.

#include "fields/field/field_precompute.h"
#include "fields/file/section_file.h"

namespace haarfield {

/// A run as sections of a file.
///
/// keys  of the field.
std::vector<Section> sample_sections(const SampleRun& run, const FieldKeys& keys);

/// The inverse.
///
/// errors  (with an empty `where`) samples of a field with other keys; a section is missing or of a wrong
///         size;
///         a defect of the pool, or a handle that it lacks.
Result<SampleRun> sections_samples(const std::vector<Section>& sections, const FieldKeys& keys);

}  // namespace haarfield
