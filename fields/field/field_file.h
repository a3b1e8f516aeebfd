#pragma once
/// Fields on disk: an OpenVDB file (vdb_store.h) that carries the field as a blob (field_blob.h), and a seal
/// over the whole file (field_seal.h).
///
/// A file appears complete or not at all. haarfield reads only the blob, in place, and uses it only after the
/// checksums and all indices and numbers have been verified (field_defect). If another program saves the file
/// again, the blob is preserved and the seal is lost.

#include "fields/base/result.h"
#include "fields/field/visibility_field.h"

#include <filesystem>

namespace haarfield {

/// The treatment of a file without a seal, such as one that another program saved. A damaged seal is always
/// an error.
enum class Unsealed {
    refused,
    allowed,  ///< The blob's own checksums are sufficient.
};

/// Writes the field to `file` atomically: to a temporary file next to it, which is synced, read back,
/// compared and renamed.
///
/// errors  a defect of the field; tables of 4 GiB or more; those of the system (full disk, read-only
///         directory ...). The target is then unchanged, and the temporary file is removed.
/// cost    about three times the field's memory.
Result<Done> write_field(const VisibilityField& field, const std::filesystem::path& file);

/// Reads a field. Its pool refers to the mapped file.
///
/// errors  the file is cut short, modified, of another version or not a field.
Result<VisibilityField> read_field(const std::filesystem::path& file, Unsealed unsealed = Unsealed::refused);

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
    bool sealed = false;
};

/// Reads and verifies a file like read_field.
Result<FieldSummary> read_field_summary(const std::filesystem::path& file,
                                        Unsealed unsealed = Unsealed::refused);

/// The data that a list of fields prints.
struct FieldCard {
    std::string entity;
    FieldKeys keys;
    Bounds bounds;  ///< [m]
    std::uint64_t planar_samples = 0, spherical_samples = 0, local_samples = 0;
    FieldError error;
    bool sealed = false;
};

/// Reads and verifies only the head of a file: neither the seal's checksum nor any table.
///
/// cost  a few pages of the file, if it has a seal.
Result<FieldCard> read_field_card(const std::filesystem::path& file);

/// The result of all checks of a file.
struct FieldVerdict {
    bool sealed = false;
    bool grids_compared = false;  ///< See verify_field.
};

/// Verifies seal, checksums, handles and indices like read_field. Then regenerates the grids for other
/// programs from the field, and requires them to be bit-identical. The grids are not compared if another
/// program or another version of OpenVDB wrote them.
///
/// errors  the first failed check.
Result<FieldVerdict> verify_field(const std::filesystem::path& file, Unsealed unsealed = Unsealed::refused);

}  // namespace haarfield
