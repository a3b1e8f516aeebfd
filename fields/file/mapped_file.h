#pragma once
/// Files mapped into memory.

#include "fields/base/result.h"

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace haarfield {

/// The bytes of a file. They start at a multiple of 4096 and stay readable while `owner` lives, even if the
/// file is removed or replaced. If a program truncates the file in place, accessing the bytes crashes. Files
/// that TemporaryFile writes are never modified in place.
struct MappedFile {
    std::string_view bytes;
    std::shared_ptr<const void> owner;
};

/// When the bytes are loaded from the disk.
enum class MappedPages {
    now,      ///< All of them at once.
    as_read,  ///< Each page on its first access. For files whose header is checked first.
};

/// Maps a regular file.
///
/// errors  those of InputFile::open, and of load_pages unless pages are loaded as they are read.
Result<MappedFile> mapped_file(const std::filesystem::path& file, MappedPages pages = MappedPages::now);

/// Loads all bytes of a file that was mapped with MappedPages::as_read.
///
/// where   the name of the file in errors
/// errors  more bytes than the machine has memory, such as those of a sparse file.
Result<Done> load_pages(const MappedFile& file, const std::string& where);

/// Removes the whole pages among some bytes of a mapped file from the memory of this process. A later access
/// loads them again.
void release_pages(std::string_view bytes);

/// Maps an open file, which stays open. `where` is the name of the file in errors.
Result<MappedFile> mapped_file(int descriptor, const std::string& where,
                               MappedPages pages = MappedPages::now);

}  // namespace haarfield
