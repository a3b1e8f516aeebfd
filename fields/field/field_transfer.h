#pragma once
/// A field as bytes, for the transfer from the reader process that reads its file (field_grids.h).
///
///     u64 bytes of the head   head: the members of FieldHead
///     cubemaps   faces   node bytes   planar handles   spherical handles   local handles
///
/// The head and each table are padded with zeros to a multiple of 64 bytes, so that the tables can be used in
/// place. Numbers are in native byte order.

#include "fields/base/byte_stream.h"
#include "fields/base/result.h"
#include "fields/field/visibility_field.h"
#include "fields/file/mapped_file.h"

namespace haarfield {

/// The numbers of elements of a field's tables.
struct FieldCounts {
    std::uint64_t cubemaps = 0, faces = 0, node_bytes = 0;
    std::uint64_t planar = 0, spherical = 0, local = 0;  ///< Handles.
};

/// A field without its tables.
struct FieldHead {
    VisibilityField field;
    FieldCounts counts;
};

void write_field_head(const FieldHead& head, ByteSink& sink);  ///< Writes the head, with its padding.

/// Writes a table with its padding.
template <class T>
void write_field_table(std::span<const T> table, ByteSink& sink);

/// Writes the zeros that follow a table.
void write_field_padding(std::uint64_t table_bytes, ByteSink& sink);

/// Reads the head.
///
/// errors  (with an empty `where`) the head is too short or too long.
Result<FieldHead> transferred_head(std::string_view bytes);

/// Reads a field, whose pool refers to the bytes. The bytes are untrusted; the sizes of the tables are
/// checked, their content is not (field_defect).
///
/// errors  (with an empty `where`) the head or a table is too short or too long.
/// cost    the handles are copied.
Result<VisibilityField> transferred_field(const MappedFile& bytes);

template <class T>
void write_field_table(std::span<const T> table, ByteSink& sink) {
    sink.bytes({reinterpret_cast<const char*>(table.data()), table.size_bytes()});
    write_field_padding(table.size_bytes(), sink);
}

}  // namespace haarfield
