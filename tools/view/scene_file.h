#pragma once
/// Saves the scene of a session without losing comments of existing files.

#include "fields/base/result.h"
#include "scenes/scene.h"

#include <set>

namespace haarfield {

/// The result of saving.
struct SavedScene {
    std::filesystem::path file;
    /// The requested file if it has comments that would be lost; otherwise empty.
    std::filesystem::path instead_of;
};

/// The file from which a session was opened, and the files that the session has written.
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
    /// cost    about 1 ms.
    /// errors  I/O errors.
    Result<Done> autosave(const Scene* scene) const;

    /// Writes a scene, with the comments at the top of the opened file.
    ///
    /// name    a file next to the opened one, with or without `.toml`; empty: the opened file. A file with
    ///         comments that would be lost is not changed. Instead, `NAME.view.toml` is written next to it,
    ///         or `NAME.view_2.toml` and so on if the session has not made the existing one.
    /// errors  an invalid name; a file with this name that is neither the opened one nor made by this
    ///         session; an unreadable file; I/O errors.
    Result<SavedScene> save(const Scene& scene, std::string_view name = {});

private:
    std::filesystem::path free_file(const std::filesystem::path& like) const;

    std::filesystem::path opened_;
    std::set<std::filesystem::path> made_;
};

}  // namespace haarfield
