#pragma once
/// Model files. Readers of our own read PLY, OFF and POV-Ray's mesh2 (polygon_file.h, mesh2_file.h). assimp
/// reads OBJ, STL and glTF, in a reader process if there is one. The format is determined by content
/// (model_format.h).

#include "fields/base/result.h"
#include "fields/mesh/listed_mesh.h"
#include "fields/model/assimp_model.h"
#include "fields/model/mesh2_file.h"
#include "fields/model/mesh_in_memory.h"
#include "fields/model/polygon_file.h"

#include <map>
#include <set>
#include <variant>

namespace haarfield {

/// For each property that haarfield does not use, such as "normal map": the names of materials that have it.
using UnusedProperties = std::map<std::string, std::set<std::string>>;

/// A model's file, read once, with access to its parts. Safe to share between threads.
class ModelFile {
public:
    /// Opens a model file.
    ///
    /// errors  those of InputFile::open; not one of model_formats; not a readable model (with its reader's
    ///         message).
    static Result<ModelFile> open(const std::filesystem::path& file);

    /// Returns the model of a file of this name that contains the mesh. Lengths of arrays and indices must be
    /// as required by MeshInMemory (asserted).
    static ModelFile of(MeshInMemory mesh, const std::string& name);

    const std::filesystem::path& file() const { return file_; }  ///< The path, or the name given to `of`.

    /// The mesh that was passed to `of`; null if a file was opened.
    const MeshInMemory* given() const { return std::get_if<MeshInMemory>(&content_); }

    /// Pieces that the file places: assimp's nodes with meshes, or mesh2 objects. Otherwise the whole file is
    /// one part with the file's name.
    const ModelParts& parts() const { return parts_; }

    /// Returns the whole file with all placements, or one part in its own frame, before repair: see
    /// FaceGatherer.
    ///
    /// errors  coordinates beyond 1e6 m; too many vertices or materials.
    Result<FaceGatherer> faces(std::optional<std::size_t> part = {}) const;

    /// True if coordinates are left-handed, as only those of POV-Ray files can be (mesh2_file.h).
    bool is_left_handed() const;

    /// Returns unused properties of materials that meshes of the file have.
    UnusedProperties unused() const;

    /// Returns the vertices and faces of the file or of one part, as the file lists them.
    ///
    /// errors  not enough memory.
    Result<ListedMesh> listed(std::optional<std::size_t> part = {}) const;

private:
    std::filesystem::path file_;
    ModelParts parts_;
    std::variant<PolygonFile, Mesh2File, AssimpModel, MeshInMemory> content_;
    std::vector<std::size_t> placed_of_part_;  ///< For Mesh2File: the first placement of each part.
};

}  // namespace haarfield
