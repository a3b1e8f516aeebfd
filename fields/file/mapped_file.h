#pragma once
/// Files read where they lie.

#include "fields/base/result.h"

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace haarfield {

/// The bytes of a file. They begin at a multiple of 4096 and stay readable while `owner` lives, also when the
/// file is removed or another one takes its name. A program that cuts the file short in place takes the
/// memory away: files that appear as TemporaryFile makes them are never changed in place.
struct MappedFile {
    std::string_view bytes;
    std::shared_ptr<const void> owner;
};

/// When the bytes are brought in.
enum class MappedPages {
    now,      ///< All of them.
    as_read,  ///< Where and when they are read.
};

/// Maps a regular file.
///
/// errors  what the system says; a folder, a pipe or a device.
Result<MappedFile> mapped_file(const std::filesystem::path& file, MappedPages pages = MappedPages::now);

/// The same of an open one, which stays open. `where` is what errors call it.
Result<MappedFile> mapped_file(int descriptor, const std::string& where,
                               MappedPages pages = MappedPages::now);

}  // namespace haarfield
