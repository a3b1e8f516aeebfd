#pragma once
/// Names and times of the files in a library of fields.

#include "fields/field/visibility_field.h"

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace haarfield {

inline constexpr std::string_view field_ending = ".vdb";      ///< The end of the names of fields.
inline constexpr std::string_view mesh_ending = ".haarmesh";  ///< The end of the names of prepared meshes.

/// Returns the 16 digits of a hash that file names contain.
std::string short_hex(const ContentHash& hash);

/// Returns a file of a library: the start of the entity's name, as far as file names allow, and `name_end`.
std::filesystem::path library_path(const std::filesystem::path& folder, std::string_view entity,
                                   std::string_view name_end);

/// Returns the files of a folder whose names have this end, sorted by name; none if there is no such folder.
std::vector<std::filesystem::path> files_ending(const std::filesystem::path& folder,
                                                std::string_view name_end);

/// Size and modification time of a file.
struct FileUse {
    std::uint64_t bytes = 0;
    std::chrono::system_clock::time_point last_used;
};

/// Returns nothing if there is no such file.
std::optional<FileUse> file_use(const std::filesystem::path& file);

/// Sets the modification time to now, at most once an hour. Does nothing without permission.
void note_use(const std::filesystem::path& file);

}  // namespace haarfield
