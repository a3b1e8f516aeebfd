#pragma once
/// The seal at the end of a field file: 64 bytes that tell whether any other has changed.
///
///     "HAARSEAL"  u32 version  u32 zero  u64 bytes of the file                24 bytes
///     u64 offset of the blob   u64 bytes of the blob (field_blob.h)           16 bytes
///     u64[2] XXH3-128 of all bytes before the seal                            16 bytes
///     u64 XXH3-64 of the seal's 56 bytes before                                8 bytes
///
/// All numbers are little endian. Seals guard against accidents, not against forgers.

#include "fields/base/result.h"
#include "fields/field/visibility_field.h"

#include <string>
#include <string_view>

namespace haarfield {

inline constexpr std::size_t field_seal_size = 64;  ///< [bytes]

/// What a seal says of the file that it ends.
struct FieldSeal {
    std::uint64_t blob_offset = 0, blob_bytes = 0;  ///< Lies before the seal.
    ContentHash content;                            ///< Of all bytes before the seal.
};

ContentHash content_hash(std::string_view bytes);  ///< XXH3 of the bytes.

/// The seal to append to a file of which only the seal is missing; the blob is a part of it.
std::string field_seal(std::string_view file, std::string_view blob);

/// Whether a file ends with a seal at all, be it damaged or not.
bool has_field_seal(std::string_view file);

/// Reads the seal at the end of a file. The content's hash is not compared.
///
/// errors  (with an empty `where`) no seal, a damaged one, or one of another size or version.
Result<FieldSeal> read_field_seal(std::string_view file);

}  // namespace haarfield
