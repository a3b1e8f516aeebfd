#pragma once
/// Fields as OpenVDB files that any OpenVDB program opens.
///
///     grid                 type       index space              voxel
///     ambient_visibility   float      x, y, z                  fraction of all directions that is open; fog
///                                                              volume for viewers, 1 outside, in the
///                                                              entity's frame (ambient_visibility.h)
///     open_direction       vec3s      x, y, z                  mean of all directions that are open, 0
///                                                              outside; likewise
///     planar_handles       int32      ring, angle, 0           handle of a cubemap; -1 outside; likewise:
///     spherical_handles    int32      shell, row, azimuth
///     local_handles        int32      bricks of 8^3 vertices   vertex i at, in bits from high to low,
///                                                              x = i[9..12] i[6..8], y = i[13..16] i[3..5],
///                                                              z = i[17..] i[0..2]
///     quadtree_pool        int32      one voxel                carries the metadata `haarfield_blob`: the
///                                                              field (field_blob.h), between zeros, at a
///                                                              multiple of 64 in the file
///
/// Every grid has the metadata `haarfield_version` (field_blob_version), `haarfield_schema`, this table's
/// line as text, and `haarfield_xxh3`: XXH3-64 of the values of its active voxels, 4 bytes a number, in the
/// order of x, y, z; of local_handles in the order of the vertices; of quadtree_pool, of the blob.
///
/// The grids of handles are there for other programs; their maps stretch them over the entity's box, so that
/// a viewer that shows all grids frames the entity. haarfield reads the blob alone and in place: no byte of a
/// file is ever parsed by OpenVDB, whose readers believe what they read. OpenVDB numbers every file at
/// random; the number is replaced by one made from the content: equal fields, equal bytes.

#include "fields/base/result.h"
#include "fields/field/visibility_field.h"

#include <string>
#include <string_view>

namespace haarfield {

/// A file in memory, and where the blob lies in it.
struct VdbFile {
    std::string bytes;
    std::size_t blob_offset = 0, blob_bytes = 0;

    /// The field's blob.
    std::string_view blob() const { return std::string_view(bytes).substr(blob_offset, blob_bytes); }
};

/// The whole file, in memory. The field must be without defect.
///
/// errors  (with an empty `where`) tables of 4 GiB or more; a failure of OpenVDB's.
/// cost    three times the file's size in memory, for a moment.
Result<VdbFile> vdb_file(const VisibilityField& field);

/// Whether this program's OpenVDB writes files of the same form as the one that wrote these bytes. If not,
/// the bytes of equal grids may differ.
bool same_vdb_library(std::string_view file);

}  // namespace haarfield
