#pragma once
/// Files of named sections that tell whether they are whole: what one process leaves for another.
///
///     "HAARPART"  u32 version  u32 sections                                     16 bytes
///     sections x { u64 bytes of the name  u64 bytes  name  bytes }
///     u64[2] XXH3-128 of all that before                                        16 bytes
///
/// All numbers are little endian.

#include "fields/base/result.h"

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace haarfield {

/// A part of such a file.
struct Section {
    std::string name, bytes;
};

/// The content of a file.
std::string section_file(const std::vector<Section>& sections);

/// Reads a file, once its checksum holds.
///
/// errors  what the system says; cut short, changed, of another version or not such a file.
Result<std::vector<Section>> read_section_file(const std::filesystem::path& file);

/// Reads the first section. Checks the length of the file, but not its checksum.
///
/// errors  those of the system; another length than that of all sections.
/// cost    a page of the file for each section, and the bytes of the first.
Result<Section> read_first_section(const std::filesystem::path& file);

/// The bytes of the section of that name; null if there is none.
const std::string* section_named(const std::vector<Section>& sections, std::string_view name);

}  // namespace haarfield
