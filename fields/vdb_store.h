#pragma once
/// Fields on disk, as OpenVDB files.

#include "fields/result.h"
#include "fields/visibility_field.h"

#include <filesystem>

namespace haarfield {

/// Writes the field to `file`, atomically: beside it, read back, compared, synced, then renamed.
/// errors  what the system said (full disk, read-only folder ...); the target is then as it was.
Result<Done> write_field(const VisibilityField& field, const std::filesystem::path& file);

/// Reads a field. A file that is cut short, changed, of another version or not ours is refused, with
/// the reason.
Result<VisibilityField> read_field(const std::filesystem::path& file);

/// The field's key alone, without reading the pool; to decide whether a file can be reused.
Result<ContentHash> read_field_key(const std::filesystem::path& file);

}  // namespace haarfield
