#pragma once
/// Creates scenes from parsed TOML tables, such as those that a program builds.

#include "scenes/scene.h"
#include "scenes/toml_table.h"

namespace haarfield {

/// The origin of tables.
struct TablesOrigin {
    std::string where;                           ///< Name in messages, such as the file.
    std::string scene_name;                      ///< Scene::name.
    std::filesystem::path folder;                ///< Base of relative paths.
    std::shared_ptr<const FilesInMemory> given;  ///< Data in place of files; null: none.
};

/// Returns the scene that tables describe, with the keys of a scene file (scenes/SCENE_FILE.md).
///
/// errors  as read_scene; without line and column for tables that a program built.
Result<Scene> scene_of_tables(const toml::table& tables, const TablesOrigin& origin);

}  // namespace haarfield
