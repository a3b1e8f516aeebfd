#pragma once
/// Mesh files in, mended: see model_file.h for what reads them.

#include "fields/base/result.h"
#include "fields/mesh/closed_pieces.h"
#include "fields/mesh/mesh.h"

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace haarfield {

class ModelFile;

/// A mesh as its file has it, mended.
struct ImportedMesh {
    Mesh mesh;
    MeshFindings findings;
    std::vector<MeshMaterial> materials{};  ///< By the mesh's materials: what the file says of them.
    std::vector<bool> mapped{};  ///< By the mesh's materials: whether its vertices have texture coordinates,
    std::vector<bool> coloured{};  ///< and colours. Which the mesh has if MeshReaderOptions::appearance.
    /// What the materials have that haarfield does not use, such as "normal map", and how many have it.
    std::map<std::string, std::size_t> unused{};
};

/// What a reader does where a file says nothing.
struct MeshReaderOptions {
    /// Where a file has no normals, faces that meet at less than this angle are smoothed. [rad]
    float crease_angle = 0.6108652f;  // 35 degrees
    /// Keep texture coordinates and colours, and so a vertex more where they part.
    bool appearance = false;
    /// Keep vertices apart that are several in the file, though they are alike.
    bool originals = false;
    /// The side on which closed pieces are visible.
    ClosedFaces faces = ClosedFaces::outwards;
};

/// Reads OBJ, PLY, glTF/GLB, STL, OFF and mesh2 (model_format.h); all its parts become one mesh in the file's
/// own coordinates (node transforms applied), read as metres with +y up.
///
/// Normals of the file are kept, normalised; missing, zero or non-finite ones are computed from the
/// faces with the crease angle. N-gons are triangulated; degenerate and duplicate triangles and
/// non-finite vertices are left out and counted. Vertices are shared where position, normal and
/// material are equal, and what is kept of the appearance.
///
/// Images are looked for in the file's folder and below, and not opened. Colours of vertices are made
/// linear: those of glTF are; others are taken as sRGB, unless a PLY file has them as floats.
///
/// Of a POV-Ray file (.inc, .pov, .mesh2, or anything else of no other format with the word mesh2 in it) all
/// mesh2 objects are read, where the file places them. A face is of the material that its first texture is
/// named for in the texture_list: NAME of `texture { NAME }`; else its number there, from 0, after the mesh's
/// name and a blank if there are several meshes. A face without a texture, and one of a mesh whose only
/// texture has no name or whose unnamed textures blend (as colours of vertices do), is of the material that
/// the mesh or the object round it has, or that is named as the mesh if there are several, or "". Coordinates
/// are read as they are written, also left-handed ones (ModelFile::is_left_handed).
///
/// errors  no such file, not a mesh that can be read (with its reader's words), no triangle left,
///         coordinates beyond 1e6 m, less than 1e-6 m large.
Result<ImportedMesh> read_mesh(const std::filesystem::path& file, const MeshReaderOptions& options = {});

/// The same of a file that is open: of one of its parts, in the part's own frame, or of all.
Result<ImportedMesh> read_mesh(const ModelFile& model, std::optional<std::size_t> part,
                               const MeshReaderOptions& options = {});

}  // namespace haarfield
