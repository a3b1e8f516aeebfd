#pragma once
/// A visibility field as bytes: the part of a field file that haarfield itself reads, in place.
///
/// All numbers are little endian; offsets count from the blob's first byte. Every section begins at a
/// multiple of 64, after zeros.
///
///     "HAARBLOB"  u32 version  u32 sections  u64 bytes                          24 bytes
///     sections x { char name[8]  u64 offset  u64 bytes  u64 XXH3-64 }           32 bytes each
///     u64 XXH3-64 of all that before                                             8 bytes
///     "entity"    the entity's name, UTF-8
///     "record"    keys, settings, bounds, samplers, error: words of 4 bytes, as FieldRecord lists them
///     "planar"    i32 handle per planar sample
///     "spheric"   i32 handle per spherical sample
///     "local"     i32 handle per fine vertex
///     "cubemaps"  PackedCubemap each
///     "faces"     PackedFace each
///     "nodes"     u8: see QuadtreePool

#include "fields/base/result.h"
#include "fields/field/visibility_field.h"

#include <memory>
#include <string>
#include <string_view>

namespace haarfield {

/// Raised whenever the bytes of equal fields change.
inline constexpr std::uint32_t field_blob_version = 6;

/// Sections, and with them the blob, lie at multiples of this. [bytes]
inline constexpr std::size_t field_blob_alignment = 64;

std::string field_blob(const VisibilityField& field);  ///< A field as the bytes of its blob.

/// The inverse. The pool's tables stay where they are in the blob, which lives as long as `owner`; where the
/// blob does not lie at a multiple of field_blob_alignment they are copied. Nothing in the field has been
/// checked but the blob's own checksums and sizes; see field_defect.
///
/// errors  (with an empty `where`) another version, a wrong checksum, a size that does not fit.
/// cost    reads every byte once.
Result<VisibilityField> blob_field(std::string_view blob, const std::shared_ptr<const void>& owner);

/// What a blob tells before its tables.
struct BlobHead {
    VisibilityField field;  ///< Without handles and pool.
    std::uint64_t planar_samples = 0, spherical_samples = 0, local_samples = 0;
};

/// Reads no more than that, and checks no other checksums than those of what it reads.
///
/// errors  as blob_field.
Result<BlobHead> blob_head(std::string_view blob);

/// The first blob in a file, by its magic number and the checksum of its header; empty if there is none.
///
/// cost  reads the file until then.
std::string_view find_field_blob(std::string_view file);

}  // namespace haarfield
