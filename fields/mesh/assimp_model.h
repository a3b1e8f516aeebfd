#pragma once
/// Model files that assimp reads.

#include "fields/base/result.h"
#include "fields/mesh/face_gatherer.h"
#include "fields/mesh/model_part.h"

#include <filesystem>
#include <memory>

namespace haarfield {

/// A file, read once. Safe to share between threads.
class AssimpModel {
public:
    /// What the file refers to is opened only beside it or below.
    ///
    /// errors  (with an empty `where`) what assimp says.
    static Result<AssimpModel> open(const std::filesystem::path& file);

    /// Whether assimp knows files of this ending, in lower case and with its point.
    static bool reads(const std::string& ending);

    const ModelParts& parts() const {
        return parts_;
    }  ///< A node with meshes, and those like it, are a part.

    void gather(FaceGatherer& to) const;                         ///< All nodes, as they stand.
    void gather_part(std::size_t part, FaceGatherer& to) const;  ///< One part, in its own frame.

private:
    struct Content;
    std::shared_ptr<const Content> content_;
    ModelParts parts_;
};

}  // namespace haarfield
