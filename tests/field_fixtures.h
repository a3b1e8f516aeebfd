#pragma once
/// Fields for tests, and field files that a forger might make.

#include "fields/vdb_store.h"

#include <string>

namespace haarfield {

/// A box with a sphere on it, at a few hundred samples.
const VisibilityField& example_field();

/// Without geometry behind it: tables of any length.
VisibilityField random_field(std::uint32_t seed, std::size_t vertices);

/// Expects equal bits throughout.
void expect_same(const VisibilityField& a, const VisibilityField& b, const std::string& which);

/// Where a section of the blob begins in the file, by its index in field_blob.h's list.
std::size_t section_offset(const VdbFile& file, std::size_t section);

/// The file with its seal, every checksum made right again where the list of sections says that it belongs.
std::string forged_file(VdbFile file);

}  // namespace haarfield
