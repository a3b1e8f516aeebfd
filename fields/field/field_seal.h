#pragma once
/// The seal: the last 64 bytes of a field file, with the size and the hash of all bytes before it.
///
///     "HAARSEAL"  u32 version  u32 zero  u64 bytes of the file        24 bytes
///     u64 offset of the blob   u64 bytes of the blob (field_blob.h)   16 bytes
///
///     u64[2] XXH3-128 of all bytes before the seal                    16 bytes
///     u64 XXH3-64 of the first 56 bytes of the seal                    8 bytes
///
/// All numbers are little endian. A seal detects accidental changes. It does not protect against forgery.

#include "fields/base/result.h"
#include "fields/field/visibility_field.h"

#include <string>
#include <string_view>

namespace haarfield {

inline constexpr std::size_t field_seal_size = 64;  ///< [bytes]

/// The content of a seal.
struct FieldSeal {
    std::uint64_t blob_offset = 0, blob_bytes = 0;  ///< The blob, which ends before the seal.
    ContentHash content;                            ///< Hash of all bytes before the seal.
};

ContentHash content_hash(std::string_view bytes);  ///< Returns the XXH3-128 hash of the bytes.

/// Returns the seal to append to a file.
///
/// file  the complete file without its seal.
/// blob  the blob inside `file`.
std::string field_seal(std::string_view file, std::string_view blob);

/// Tests whether a file ends with a seal, intact or damaged.
bool has_field_seal(std::string_view file);

/// Reads the seal at the end of a file. The hash of the content is not compared.
///
/// errors  (with an empty `where`) no seal, a damaged seal, another version, or another size of the file.
Result<FieldSeal> read_field_seal(std::string_view file);

}  // namespace haarfield
