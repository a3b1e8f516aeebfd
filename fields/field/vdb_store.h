#pragma once
/// Fields as OpenVDB files, which any OpenVDB program can open.
///
/// Two grids are for viewers, in the frame of the entity (ambient_visibility.h):
///
///     grid                 type    index space  voxel
///     ambient_visibility   float   x, y, z      unoccluded fraction of all directions; a fog volume with
///                                               background 1
///     open_direction       vec3s   x, y, z      mean of the unoccluded directions; background 0
///
/// Three grids contain the handle of a cubemap at each sample; their background is -1:
///
///     planar_handles       int32   ring, angle, 0
///     spherical_handles    int32   shell, row, azimuth
///     local_handles        int32   bricks of 8^3 vertices
///
/// Bits of the index i of a vertex, from high to low, give its voxel in local_handles:
/// x = i[9..12] i[6..8], y = i[13..16] i[3..5], z = i[17..] i[0..2].
///
/// The grid quadtree_pool (int32, one voxel) has the metadata `haarfield_blob`: the blob of the field
/// (field_blob.h). Zeros before the blob put it at a multiple of 64 bytes in the file.
///
/// Every grid has three more metadata: `haarfield_version` (field_blob_version), `haarfield_schema` (its
/// description as text), and the hash `haarfield_xxh3`. This is XXH3-64 of the values of the active voxels,
/// 4 bytes per number, in the order of x, y, z. For local_handles the order is that of the vertices. For
/// quadtree_pool it is the hash of the blob.
///
/// The grids of handles are for other programs. Their transforms stretch them over the bounding box of the
/// entity, so that a viewer that shows all grids frames the entity. haarfield itself reads only the blob, in
/// place. OpenVDB never parses a file for haarfield, because its readers trust their input. OpenVDB gives
/// each file a random UUID. A UUID computed from the content replaces it, so that equal fields have equal
/// bytes.

#include "fields/base/result.h"
#include "fields/field/visibility_field.h"

#include <string>
#include <string_view>

namespace haarfield {

/// A field file in memory, and the position of its blob.
struct VdbFile {
    std::string bytes;
    std::size_t blob_offset = 0, blob_bytes = 0;

    /// Returns the blob of the field.
    std::string_view blob() const { return std::string_view(bytes).substr(blob_offset, blob_bytes); }
};

/// Returns the file of a field without its seal. The field must have no defect (field_defect).
///
/// errors  (with an empty `where`) tables of 4 GiB or more; a failure of OpenVDB.
/// cost    temporarily three times the size of the file in memory.
Result<VdbFile> vdb_file(const VisibilityField& field);

/// Tests whether the OpenVDB that wrote a file has the library and format version of the OpenVDB in this
/// program. If not, equal grids may have different bytes.
bool same_vdb_library(std::string_view file);

}  // namespace haarfield
