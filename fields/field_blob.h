#pragma once
/// Visibility fields as bytes: what a field file holds beside its voxels, and the seal at its end.
///
/// All numbers are little endian. The blob, without gaps:
///
///     "HAARBLOB"  u32 version  u32 sections  u64 bytes                          24 bytes
///     sections x { char name[8]  u64 offset  u64 bytes  u64 XXH3-64 }           32 bytes each
///     u64 XXH3-64 of all that before                                             8 bytes
///     "entity"    the entity's name, UTF-8
///     "record"    settings, bounds, samplers, error: 28 words of 4 bytes
///     "cubemaps"  u32[6] each: face indices
///     "faces"     u32 first byte of the nodes, u16 nodes, u16 mean (half float) each
///     "nodes"     u8: see QuadtreePool
///
/// The seal, the last 64 bytes of a field file:
///
///     "HAARSEAL"  u32 version  u32 zero  u64 bytes of the file
///     u64[2] key of the field   u64[2] XXH3-128 of all bytes before the seal
///     u64 XXH3-64 of the seal's 56 bytes before

#include "fields/result.h"
#include "fields/visibility_field.h"

#include <string>
#include <string_view>

namespace haarfield {

/// Everything of a field but its key and its handles.
std::string field_blob(const VisibilityField& field);

/// The inverse: a field without key and handles. Nothing in it has been checked but the blob's own
/// checksums and sizes; see field_defect.
///
/// errors  (with an empty `where`) another version, a wrong checksum, a size that does not fit.
Result<VisibilityField> blob_field(std::string_view blob);

inline constexpr std::size_t field_seal_size = 64;  ///< [bytes]

/// What a seal says of the file that it ends.
struct FieldSeal {
    ContentHash key;
    ContentHash content;  ///< Of all bytes before the seal.
};

ContentHash content_hash(std::string_view bytes);

/// The seal to append to a file of which only the seal is missing.
std::string field_seal(std::string_view file, const ContentHash& key);

/// Reads a seal.
///
/// end         the last field_seal_size bytes of a file, or all of a shorter one.
/// file_bytes  size of the file.
/// errors      (with an empty `where`) no seal, a damaged one, or one of another size or version.
Result<FieldSeal> read_field_seal(std::string_view end, std::uint64_t file_bytes);

}  // namespace haarfield
