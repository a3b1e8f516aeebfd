#pragma once
/// Fields as OpenVDB grids, which are the content of a field file. README.md of this folder specifies the
/// format.

#include "fields/base/byte_stream.h"
#include "fields/base/result.h"
#include "fields/field/visibility_field.h"
#include "fields/file/reader_process.h"

#include <string>
#include <string_view>

namespace haarfield {

/// Version of the format. It increases whenever the grids of equal fields change.
inline constexpr std::int32_t field_format_version = 7;

/// Returns the file of a field. The field must have no defect (field_defect).
///
/// errors  (with an empty `where`) a failure of OpenVDB.
/// cost    temporarily three times the memory of the field.
Result<std::string> field_file_bytes(const VisibilityField& field);

/// What is read of a file.
enum class FieldContent {
    head,   ///< The metadata of the grids alone. No hash is verified.
    whole,  ///< All grids.
};

/// Reads the grids of a file with OpenVDB, verifies their hashes, and writes the field as field_transfer.h
/// describes. OpenVDB trusts its input, so that programs call this function in a reader process.
///
/// errors  (with an empty `where`) the file is cut short or not a field; a grid is missing, unknown, changed,
///         or belongs to another field; another version. Throws the exceptions of OpenVDB.
/// memory  one grid at a time: at most 8 MiB, but for more than 10^6 faces or samples.
Result<Done> read_field_grids(std::string_view bytes, FieldContent content, ByteSink& answer);

/// Returns the task of reader processes that calls read_field_grids.
ReaderTask field_reader_task();

/// Reads the bytes of field_transfer.h from an open file, in a reader process if there is one.
///
/// file    a regular file.
/// where   the name of the file in errors.
/// errors  those of read_field_grids and of read_apart.
Result<MappedFile> guarded_field(int file, FieldContent content, const std::string& where);

}  // namespace haarfield
