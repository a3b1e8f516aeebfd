#pragma once
/// Reading and repair of mesh files: see model_file.h for the formats' readers.

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

/// A mesh from a file, repaired.
struct ImportedMesh {
    Mesh mesh;
    MeshFindings findings;
    std::vector<MeshMaterial> materials{};  ///< The properties of the mesh's materials in the file.
    /// By the mesh's materials: true if their vertices have texture coordinates. The mesh has texture
    /// coordinates and colours only with MeshReaderOptions::appearance.
    std::vector<bool> mapped{};
    /// By the mesh's materials: true if their vertices have colours.
    std::vector<bool> coloured{};
    /// Properties that haarfield does not use, such as "normal map", and the number of materials with each.
    std::map<std::string, std::size_t> unused{};
};

/// Options for reading meshes.
struct MeshReaderOptions {
    /// If a file has no normals, faces that meet at less than this angle are smoothed. [rad]
    float crease_angle = 0.6108652f;  // 35 degrees
    /// Keep texture coordinates and colours, and split vertices where they differ.
    bool appearance = false;
    /// Keep vertices separate that are separate in the file, even if they are equal.
    bool originals = false;
    /// The side on which closed pieces are visible.
    ClosedFaces faces = ClosedFaces::outwards;
};

/// Reads OBJ, PLY, glTF/GLB, STL, OFF and mesh2 (model_format.h). All parts become one mesh in the file's
/// coordinates (node transforms applied), read as metres with +y up.
///
/// Normals of the file are kept and normalised. Missing, zero or non-finite normals are computed from the
/// faces with the crease angle. N-gons are triangulated. Degenerate and duplicate triangles and non-finite
/// vertices are removed and counted. Corners share a vertex if position, normal, material and all kept
/// appearance are equal.
///
/// Images are searched for in the file's directory and below, but not opened. Vertex colours are converted to
/// linear, as those of glTF already are. Others are assumed to be sRGB, except floats of PLY files.
///
/// In a POV-Ray file (.inc, .pov, .mesh2, or a file of no other format that contains the word mesh2), all
/// mesh2 objects are read at their placements. The material of a face is that of its first texture in the
/// texture_list: NAME of `texture { NAME }`, or else its index from 0, preceded by the mesh's name and a
/// blank if there are several meshes. Some faces have no texture, the only and unnamed texture of a mesh, or
/// a blend of unnamed textures (as vertex colours have). These use the material of the mesh or the enclosing
/// object, or else one with the mesh's name if there are several meshes, or "". Coordinates are read as
/// written, also left-handed ones (ModelFile::is_left_handed).
///
/// errors  no such file; not a readable mesh (with its reader's message); no triangles left; coordinates
///         beyond 1e6 m; smaller than 1e-6 m.
Result<ImportedMesh> read_mesh(const std::filesystem::path& file, const MeshReaderOptions& options = {});

/// Reads an open file: one of its parts, in the part's own frame, or all of it.
Result<ImportedMesh> read_mesh(const ModelFile& model, std::optional<std::size_t> part,
                               const MeshReaderOptions& options = {});

}  // namespace haarfield
