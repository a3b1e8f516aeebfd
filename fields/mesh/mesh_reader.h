#pragma once
/// Mesh files in: PLY and OFF with readers of our own (polygon_file.h), all others through assimp.

#include "fields/base/result.h"
#include "fields/mesh/mesh.h"

#include <filesystem>

namespace haarfield {

/// A mesh as its file has it, mended.
struct ImportedMesh {
    Mesh mesh;
    MeshFindings findings;
};

/// What a reader does where a file says nothing.
struct MeshReaderOptions {
    /// Where a file has no normals, faces that meet at less than this angle are smoothed. [rad]
    float crease_angle = 0.6108652f;  // 35 degrees
};

/// Reads OBJ, PLY, glTF/GLB, STL, OFF and whatever else assimp reads; all its parts become one mesh
/// in the file's own coordinates (node transforms applied), read as metres with +y up.
///
/// Normals of the file are kept, normalised; missing, zero or non-finite ones are computed from the
/// faces with the crease angle. N-gons are triangulated; degenerate and duplicate triangles and
/// non-finite vertices are left out and counted. Vertices are shared where position, normal and
/// material are equal.
///
/// errors  no such file, not a mesh that can be read (with its reader's words), no triangle left,
///         coordinates beyond 1e6 m.
Result<ImportedMesh> read_mesh(const std::filesystem::path& file, const MeshReaderOptions& options = {});

}  // namespace haarfield
