#pragma once
/// Scenes from tables that a program holds: what a scene file is once it is parsed.

#include "scenes/scene.h"
#include "scenes/toml_table.h"

namespace haarfield {

/// Where tables are from.
struct TablesOrigin {
    std::string where;                        ///< What messages call it, such as the file.
    std::string scene_name;                   ///< Scene::name.
    std::filesystem::path folder;             ///< That relative paths start from.
    std::shared_ptr<const GivenFiles> given;  ///< What stands in place of files; null: nothing.
};

/// The scene that tables describe, with the keys of a scene file (README).
///
/// errors  as read_scene: of tables that a program made, without line and column.
Result<Scene> scene_of_tables(const toml::table& tables, const TablesOrigin& origin);

}  // namespace haarfield
