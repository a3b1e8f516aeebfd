#pragma once
/// Where the scene of a session is saved, so that nothing is lost that a person has written.

#include "fields/base/result.h"
#include "scenes/scene.h"

#include <set>

namespace haarfield {

/// What saving has come to.
struct SavedScene {
    std::filesystem::path file;
    std::filesystem::path instead_of;  ///< What was to be written and has comments; else empty.
};

/// The file that a session was opened from, and those that it has written.
class SceneFile {
public:
    explicit SceneFile(std::filesystem::path opened) : opened_(std::move(opened)) {}

    const std::filesystem::path& opened() const { return opened_; }

    /// The autosave file: `NAME.autosave.toml` next to the scene.
    std::filesystem::path autosave_file() const;

    /// Reads the autosave file that an earlier session has left; none if there is no such file.
    ///
    /// errors  those of read_scene.
    std::optional<Result<Scene>> left_scene() const;

    /// Writes a scene to the autosave file, or removes that file if the scene is null.
    ///
    /// cost    some 1 ms.
    /// errors  of the file system.
    Result<Done> autosave(const Scene* scene) const;

    /// Writes a scene, with the comments on top of the file that was opened.
    ///
    /// name    of the file, beside that which was opened, with or without `.toml`; empty: into that one.
    ///         A file with comments that would be lost stays as it is: `NAME.view.toml` beside it is written
    ///         instead, or `NAME.view_2.toml` and so on, where there is one that this session has not made.
    /// errors  no name for a scene; a file of that name that is neither the one opened nor made by this
    ///         session; a file that can not be read; what the system says of writing.
    Result<SavedScene> save(const Scene& scene, std::string_view name = {});

private:
    std::filesystem::path free_file(const std::filesystem::path& like) const;

    std::filesystem::path opened_;
    std::set<std::filesystem::path> made_;
};

}  // namespace haarfield
