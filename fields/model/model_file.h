#pragma once
/// Model files: PLY, OFF and POV-Ray's mesh2 by readers of our own (polygon_file.h, mesh2_file.h); OBJ, STL
/// and glTF through assimp, in a reader process where there is one. What a file is, its content decides
/// (model_format.h).

#include "fields/base/result.h"
#include "fields/mesh/listed_mesh.h"
#include "fields/model/assimp_model.h"
#include "fields/model/given_mesh.h"
#include "fields/model/mesh2_file.h"
#include "fields/model/polygon_file.h"

#include <map>
#include <set>
#include <variant>

namespace haarfield {

/// Names of materials by what they have that haarfield does not use, such as "normal map".
using UnusedProperties = std::map<std::string, std::set<std::string>>;

/// A model's file, read once, of which parts are taken. Safe to share between threads.
class ModelFile {
public:
    /// errors  those of InputFile::open; none of model_formats; not a model that can be read (with its
    ///         reader's words).
    static Result<ModelFile> open(const std::filesystem::path& file);

    /// As if a file of this name held the mesh. Its arrays have the lengths, and the indices the range, that
    /// GivenMesh wants (asserted).
    static ModelFile of(GivenMesh mesh, const std::string& name);

    const std::filesystem::path& file() const { return file_; }

    /// The mesh that `of` was given; null if a file was opened.
    const GivenMesh* given() const { return std::get_if<GivenMesh>(&content_); }

    /// Pieces that the file places: assimp's nodes with meshes, mesh2 objects; else all of it is one, of the
    /// file's name.
    const ModelParts& parts() const { return parts_; }

    /// All of the file, as it stands; or one part, in its own frame. As the file has it: see FaceGatherer.
    ///
    /// errors  coordinates beyond 1e6 m, too many vertices or materials.
    Result<FaceGatherer> faces(std::optional<std::size_t> part = {}) const;

    /// Tests whether coordinates are left-handed: only those of POV-Ray are (mesh2_file.h).
    bool is_left_handed() const;

    /// Of the materials that meshes of the file have.
    UnusedProperties unused() const;

    /// Its vertices and faces, or those of a part, as the file lists them.
    ///
    /// errors  more memory than there is.
    Result<ListedMesh> listed(std::optional<std::size_t> part = {}) const;

private:
    std::filesystem::path file_;
    ModelParts parts_;
    std::variant<PolygonFile, Mesh2File, AssimpModel, GivenMesh> content_;
    std::vector<std::size_t> placed_of_part_;  ///< Of Mesh2File: where each part stands first.
};

}  // namespace haarfield
