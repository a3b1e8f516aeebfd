#pragma once
/// The blob of a visibility field: the bytes of a field file that haarfield reads, in place.
///
/// All numbers are little endian. Offsets count from the first byte of the blob. Each section begins at a
/// multiple of 64 bytes; zeros fill the gaps. The header:
///
///     "HAARBLOB"  u32 version  u32 number of sections  u64 bytes of the blob    24 bytes
///
///     for each section { char name[8]  u64 offset  u64 bytes  u64 XXH3-64 }     32 bytes
///     u64 XXH3-64 of the header up to here                                       8 bytes
///
/// The sections, in this order:
///
///     "entity"    name of the entity, UTF-8
///     "record"    keys, settings, bounds, samplers, error: the 4-byte words of FieldRecord
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

/// Version of the format. It increases whenever the bytes of equal fields change.
inline constexpr std::uint32_t field_blob_version = 6;

/// Alignment of the blob and of its sections. [bytes]
inline constexpr std::size_t field_blob_alignment = 64;

std::string field_blob(const VisibilityField& field);  ///< Returns the blob of a field.

/// Returns the field of a blob, the inverse of field_blob. The pool of the field refers to the tables inside
/// the blob, which must live as long as `owner`. Tables that are not aligned in memory are copied. Only the
/// checksums and sizes are verified; field_defect verifies the content.
///
/// errors  (with an empty `where`) another version, a wrong checksum, a wrong size.
/// cost    reads every byte once.
Result<VisibilityField> blob_field(std::string_view blob, const std::shared_ptr<const void>& owner);

/// The data at the start of a blob, and the numbers of samples.
struct BlobHead {
    VisibilityField field;  ///< Without handles and pool.
    std::uint64_t planar_samples = 0, spherical_samples = 0, local_samples = 0;
};

/// Reads the head of a blob, and verifies the checksums of the header and of the first two sections only.
///
/// errors  as blob_field.
Result<BlobHead> blob_head(std::string_view blob);

/// Returns the first blob in a file, found by its magic number and the checksum of its header; empty if there
/// is none.
///
/// cost  reads the file up to the blob.
std::string_view find_field_blob(std::string_view file);

}  // namespace haarfield
