#pragma once
/// Model files that assimp reads.

#include "fields/base/result.h"
#include "fields/mesh/listed_mesh.h"
#include "fields/model/face_gatherer.h"
#include "fields/model/model_format.h"
#include "fields/model/model_part.h"

#include <filesystem>
#include <memory>

namespace haarfield {

/// The content of a file, read once. Safe to share between threads.
class AssimpModel {
public:
    /// Reads a file, in a reader process if there is one (reader_process.h). Files that it refers to are
    /// opened only in its directory or below.
    ///
    /// bytes   a file of a format that assimp reads: OBJ, STL, glTF.
    /// errors  (with an empty `where`) those of assimp; the reader crashed or exceeded its limits.
    static Result<AssimpModel> from(std::string_view bytes, const std::filesystem::path& file,
                                    ModelFormat format);

    /// A part is a node with meshes, together with all nodes like it.
    const ModelParts& parts() const { return parts_; }

    void gather(FaceGatherer& to) const;                         ///< Adds all nodes in world coordinates.
    void gather_part(std::size_t part, FaceGatherer& to) const;  ///< Adds one part, in its own frame.

    /// The value of ModelFile::unused.
    std::map<std::string, std::set<std::string>> unused() const;

    /// Returns the vertices and faces that the file lists, of all nodes or of one part. Invalid faces, with a
    /// corner that is not a vertex, are omitted.
    ListedMesh listed(std::optional<std::size_t> part) const;

private:
    struct Content;
    std::shared_ptr<const Content> content_;
    ModelParts parts_;
};

}  // namespace haarfield
