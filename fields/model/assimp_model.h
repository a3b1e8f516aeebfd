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

/// A file, read once. Safe to share between threads.
class AssimpModel {
public:
    /// What the file refers to is opened only beside it or below. Where there is a reader process, that one
    /// reads it: see reader_process.h.
    ///
    /// bytes   of the file, of a format that assimp is there for: OBJ, STL, glTF.
    /// errors  (with an empty `where`) what assimp says; that it crashed, or took more than it may.
    static Result<AssimpModel> from(std::string_view bytes, const std::filesystem::path& file,
                                    ModelFormat format);

    /// A node with meshes, and those like it, are a part.
    const ModelParts& parts() const { return parts_; }

    void gather(FaceGatherer& to) const;                         ///< All nodes, as they stand.
    void gather_part(std::size_t part, FaceGatherer& to) const;  ///< One part, in its own frame.

    /// ModelFile::unused.
    std::map<std::string, std::set<std::string>> unused() const;

    /// The vertices and faces that the file lists, of all nodes or of one part. Of faces that no file may
    /// have (a corner that is none of the vertices) there are none.
    ListedMesh listed(std::optional<std::size_t> part) const;

private:
    struct Content;
    std::shared_ptr<const Content> content_;
    ModelParts parts_;
};

}  // namespace haarfield
