#pragma once
/// Fields on disk: OpenVDB files whose grids are the field (field_grids.h).
///
/// A file appears complete or not at all. A reader process parses it (fields/file/reader_process.h). The
/// hashes of the grids, all indices and all numbers are verified (field_defect). A file that another program
/// saved again remains valid as long as values and metadata are unchanged.

#include "fields/base/result.h"
#include "fields/field/visibility_field.h"
#include "fields/vdb/vdb_file.h"

#include <filesystem>

namespace haarfield {

/// Writes the field to `file` atomically: to a temporary file next to it, which is synced, read back,
/// compared and renamed.
///
/// errors  a defect of the field; those of the system (full disk, read-only directory ...). The target is
///         then unchanged, and the temporary file is removed.
/// cost    about three times the field's memory.
Result<Done> write_field(const VisibilityField& field, const std::filesystem::path& file);

/// Reads a field. Its pool refers to the memory that the reader process filled.
///
/// errors  the file is cut short, changed, of another version or not a field; those of guarded_read.
/// cost    about 5 ns per byte.
/// memory  the field's own; up to 8 MiB more while it is read.
Result<VisibilityField> read_field(const std::filesystem::path& file);

/// The data that `haarfield info` prints.
struct FieldSummary {
    std::string entity;
    FieldKeys keys;
    FieldSettings settings;
    Bounds bounds;  ///< [m]
    PlanarSampler planar;
    SphericalSampler spherical;
    std::uint64_t local_samples = 0;                   ///< Vertices of the fine mesh.
    std::uint64_t cubemaps = 0, faces = 0, nodes = 0;  ///< Equal ones are counted once.
    FieldError error;
    std::uint64_t file_bytes = 0;
};

/// Reads and verifies a file like read_field.
Result<FieldSummary> read_field_summary(const std::filesystem::path& file);

/// Tests whether a file has grids of a field, of any version.
bool is_field(const VdbListing& listing);

/// The data that a list of fields prints.
struct FieldCard {
    std::string entity;
    FieldKeys keys;
    Bounds bounds;  ///< [m]
    std::uint64_t planar_samples = 0, spherical_samples = 0, local_samples = 0;
    FieldError error;
};

/// Reads the metadata of a file alone, and verifies no hash.
///
/// cost  a few pages of the file.
Result<FieldCard> read_field_card(const std::filesystem::path& file);

/// Reads and verifies a file like read_field. Then recomputes the grids for other programs from the field,
/// and compares them.
///
/// accuracy  these grids may differ by 1e-5, because compilers round differently.
/// errors    the first failed check.
Result<Done> verify_field(const std::filesystem::path& file);

}  // namespace haarfield
