#pragma once
/// Files of named sections with a checksum, which one process writes for another or for a later one.
///
///     "HAARPART"  u32 version  u32 number of sections                           16 bytes
///     for each section { u64 bytes of the name  u64 bytes  name  bytes }
///     u64[2] XXH3-128 of all bytes before                                       16 bytes
///
/// All numbers are little endian.

#include "fields/base/result.h"

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace haarfield {

/// A section of such a file.
struct Section {
    std::string name, bytes;
};

/// Returns the content of a file with these sections.
std::string section_file(const std::vector<Section>& sections);

/// Reads a file and verifies its checksum.
///
/// errors  those of the system; the file is cut short, modified, of another version or not a section file.
Result<std::vector<Section>> read_section_file(const std::filesystem::path& file);

/// Reads the first section. Checks the length of the file, but not its checksum.
///
/// errors  those of the system; the length of the file is not that of its sections.
/// cost    one page of the file per section, and the bytes of the first section.
Result<Section> read_first_section(const std::filesystem::path& file);

/// Returns the bytes of the section with that name; null if there is none.
const std::string* section_named(const std::vector<Section>& sections, std::string_view name);

}  // namespace haarfield
