#pragma once
/// Fields on disk, as OpenVDB files that any OpenVDB program opens.
///
///     grid                 type       index space              voxel
///     ambient_visibility   float      x, y, z                  fraction of all directions that is open; fog
///                                                              volume for viewers, 1 outside, in the
///                                                              entity's frame (ambient_visibility.h)
///     planar_handles       int32      ring, angle, 0           handle of a cubemap; -1 outside; likewise:
///     spherical_handles    int32      shell, row, azimuth
///     local_handles        int32      bricks of 8^3 vertices   vertex i at, in bits from high to low,
///                                                              x = i[9..12] i[6..8], y = i[13..16] i[3..5],
///                                                              z = i[17..] i[0..2]
///     quadtree_pool        int32      one voxel                carries the metadata `haarfield_blob`: all
///     else
///                                                              (field_blob.h)
///     after the last grid             64 bytes                 seal over the whole file (field_blob.h)
///
/// The maps of the handle grids stretch their charts over the entity's box, so that a viewer that shows all
/// grids frames the entity. OpenVDB numbers every file at random; the number is replaced by one made from
/// the content: equal fields, equal files, bit for bit. A program that saves the file again drops the seal:
/// such a file is refused. Seals guard against accidents, not against forgers; still, nothing in a file whose
/// seal holds is used before it has been checked (field_defect).

#include "fields/result.h"
#include "fields/visibility_field.h"

#include <filesystem>

namespace haarfield {

/// Writes the field to `file`, atomically: beside it, read back, compared, synced, then renamed.
///
/// errors  a defect of the field; tables of 4 GiB or more; what the system said (full disk, read-only
///         folder ...). The target is then as it was, and nothing lies beside it.
/// cost    about four times the field's memory.
Result<Done> write_field(const VisibilityField& field, const std::filesystem::path& file);

/// Reads a field. A file that is cut short, changed, of another version or not ours is refused, with
/// the reason, before OpenVDB sees it.
Result<VisibilityField> read_field(const std::filesystem::path& file);

/// The field's key, from the seal alone; to decide whether a file can be reused. Whether the rest of the file
/// is whole, read_field tells.
Result<ContentHash> read_field_key(const std::filesystem::path& file);

/// What `haarfield info` shows.
struct FieldSummary {
    std::string entity;
    ContentHash key;
    FieldSettings settings;
    Bounds bounds;  ///< [m]
    PlanarSampler planar;
    SphericalSampler spherical;
    std::uint64_t local_samples = 0;                   ///< Vertices of the fine mesh.
    std::uint64_t cubemaps = 0, faces = 0, nodes = 0;  ///< Stored, equal ones once.
    FieldError error;
    std::uint64_t file_bytes = 0;
};

/// Reads and checks all of the file.
Result<FieldSummary> read_field_summary(const std::filesystem::path& file);

/// Checks the seal, every checksum, every handle and index. The error gives the reason.
Result<Done> verify_field(const std::filesystem::path& file);

}  // namespace haarfield
