#pragma once
/// Fields on disk: an OpenVDB file (vdb_store.h) that carries the field as a blob (field_blob.h), and a seal
/// over all of it (field_seal.h).
///
/// A file appears whole or not at all. haarfield reads the blob in place and nothing else, and nothing in it
/// is used before the checksums hold and every index and number has been checked (field_defect). Another
/// program that saves the file again keeps the blob and drops the seal.

#include "fields/base/result.h"
#include "fields/field/visibility_field.h"

#include <filesystem>

namespace haarfield {

/// What to do with a file that has no seal, as after another program saved it. A damaged seal is always
/// refused.
enum class Unsealed {
    refused,
    allowed,  ///< The blob's own checksums decide.
};

/// Writes the field to `file`, atomically: beside it, synced, read back and compared, then renamed.
///
/// errors  a defect of the field; tables of 4 GiB or more; what the system says (full disk, read-only
///         folder ...). The target is then as it was, and nothing lies beside it.
/// cost    about three times the field's memory.
Result<Done> write_field(const VisibilityField& field, const std::filesystem::path& file);

/// Reads a field. A file that is cut short, changed, of another version or not ours is refused, with the
/// reason. The field's pool lies in the mapped file.
Result<VisibilityField> read_field(const std::filesystem::path& file, Unsealed unsealed = Unsealed::refused);

/// What `haarfield info` shows.
struct FieldSummary {
    std::string entity;
    FieldKeys keys;
    FieldSettings settings;
    Bounds bounds;  ///< [m]
    PlanarSampler planar;
    SphericalSampler spherical;
    std::uint64_t local_samples = 0;                   ///< Vertices of the fine mesh.
    std::uint64_t cubemaps = 0, faces = 0, nodes = 0;  ///< Stored, equal ones once.
    FieldError error;
    std::uint64_t file_bytes = 0;
    bool sealed = false;
};

/// Reads and checks all that read_field does.
Result<FieldSummary> read_field_summary(const std::filesystem::path& file,
                                        Unsealed unsealed = Unsealed::refused);

/// What a list of fields shows.
struct FieldCard {
    std::string entity;
    FieldKeys keys;
    Bounds bounds;  ///< [m]
    std::uint64_t planar_samples = 0, spherical_samples = 0, local_samples = 0;
    FieldError error;
    bool sealed = false;
};

/// Reads the head of a file, and checks that alone: neither the seal's checksum nor any table.
///
/// cost  a few pages of the file, if it has a seal.
Result<FieldCard> read_field_card(const std::filesystem::path& file);

/// What is known of a file after all checks.
struct FieldVerdict {
    bool sealed = false;
    bool grids_compared = false;  ///< See verify_field.
};

/// Checks seal, checksums, handles and indices, as read_field does; and the grids for other programs, by
/// making them anew from the field: they must be the same, bit for bit. That cannot be told, and is left out,
/// if another version of OpenVDB or another program wrote them.
///
/// errors  the reason why the file is not good.
Result<FieldVerdict> verify_field(const std::filesystem::path& file, Unsealed unsealed = Unsealed::refused);

}  // namespace haarfield
