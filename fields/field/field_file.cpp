#include "fields/field/field_file.h"

#include "fields/field/field_blob.h"
#include "fields/field/field_seal.h"
#include "fields/field/vdb_store.h"
#include "fields/file/mapped_file.h"
#include "fields/file/temporary_file.h"

#include <fmt/format.h>

namespace haarfield {
namespace {

using std::filesystem::path;

struct OpenedField {
    VisibilityField field;
    MappedFile file;
    bool sealed = false;
};

/// A file without a seal is searched for its blob. Other programs may have added grids to it. [bytes]
constexpr std::uint64_t largest_unsealed = std::uint64_t{16} << 30;

/// Returns the size of the largest file that write_field makes of a blob. As grids, handles take less than 32
/// times their size in the blob. Grids of visibility have a fixed size. [bytes]
std::uint64_t largest_sealed(std::uint64_t blob_bytes) {
    return (std::uint64_t{8} << 20) + 32 * blob_bytes;
}

/// Finds the field's blob by the seal, or by a search if the file has no seal. Checks sizes and headers. Of a
/// file with a seal it reads nothing else, so that a sparse file of any size is rejected at once.
Result<std::string_view> plausible_blob(std::string_view file, Unsealed unsealed) {
    if (unsealed == Unsealed::allowed && !has_field_seal(file)) {
        if (file.size() > largest_unsealed)
            return Error{"", fmt::format("has {} bytes and no seal; expected at most {}", file.size(),
                                         largest_unsealed)};
        const std::string_view blob = find_field_blob(file);
        if (blob.empty())
            return Error{"", "has neither a seal nor a field's tables: it is cut short, or not a field"};
        return blob;
    }
    HF_TRY(const FieldSeal seal, read_field_seal(file));
    const std::string_view blob = file.substr(seal.blob_offset, seal.blob_bytes);
    if (const Result<BlobHead> head = blob_head(blob); !head) return head.error();
    if (file.size() > largest_sealed(blob.size()))
        return Error{"", fmt::format("has {} bytes; expected at most {} for its tables", file.size(),
                                     largest_sealed(blob.size()))};
    return blob;
}

/// Returns the field's blob if the checksum of the seal is correct.
Result<std::string_view> checked_blob(std::string_view file, Unsealed unsealed) {
    const Result<std::string_view> blob = plausible_blob(file, unsealed);
    if (!blob || !has_field_seal(file)) return blob;
    HF_TRY(const FieldSeal seal, read_field_seal(file));
    if (content_hash(file.substr(0, file.size() - field_seal_size)) != seal.content)
        return Error{"", "the file was changed or damaged since it was written: its checksum is wrong"};
    return blob;
}

Result<OpenedField> opened_field(const path& file, Unsealed unsealed) {
    const auto refusal = [&](const std::string& reason) { return Error{file.string(), reason}; };
    HF_TRY(MappedFile mapped, mapped_file(file, MappedPages::as_read));
    if (const Result<std::string_view> blob = plausible_blob(mapped.bytes, unsealed); !blob)
        return refusal(blob.error().what);
    HF_TRY_DONE(load_pages(mapped, file.string()));
    const Result<std::string_view> blob = checked_blob(mapped.bytes, unsealed);
    if (!blob) return refusal(blob.error().what);
    Result<VisibilityField> field = blob_field(*blob, mapped.owner);
    if (!field) return refusal(field.error().what);
    if (const std::string defect = field_defect(*field); !defect.empty()) return refusal(defect);
    return OpenedField{*std::move(field), std::move(mapped), has_field_seal(mapped.bytes)};
}

}  // namespace

Result<Done> write_field(const VisibilityField& field, const path& file) {
    const std::string where = file.string();
    if (const std::string defect = field_defect(field); !defect.empty())
        return Error{where, "the field has a defect and was not written: " + defect};
    Result<VdbFile> made = vdb_file(field);
    if (!made) return Error{where, made.error().what};
    made->bytes += field_seal(made->bytes, made->blob());
    HF_TRY(TemporaryFile temporary, TemporaryFile::beside(file));
    HF_TRY_DONE(temporary.write(made->bytes));
    return temporary.replace_target(made->bytes);
}

Result<VisibilityField> read_field(const path& file, Unsealed unsealed) {
    HF_TRY(OpenedField opened, opened_field(file, unsealed));
    return std::move(opened.field);
}

Result<FieldSummary> read_field_summary(const path& file, Unsealed unsealed) {
    HF_TRY(const OpenedField opened, opened_field(file, unsealed));
    const VisibilityField& field = opened.field;
    FieldSummary summary;
    summary.entity = field.entity;
    summary.keys = field.keys;
    summary.settings = field.settings;
    summary.bounds = field.bounds;
    summary.planar = field.planar;
    summary.spherical = field.spherical;
    summary.local_samples = field.local_handles.size();
    summary.cubemaps = field.pool.cubemaps.size();
    summary.faces = field.pool.faces.size();
    summary.nodes = node_count(field.pool);
    summary.error = field.error;
    summary.file_bytes = opened.file.bytes.size();
    summary.sealed = opened.sealed;
    return summary;
}

Result<FieldCard> read_field_card(const path& file) {
    HF_TRY(const MappedFile mapped, mapped_file(file, MappedPages::as_read));
    const bool sealed = has_field_seal(mapped.bytes);
    const Result<std::string_view> blob = plausible_blob(mapped.bytes, Unsealed::allowed);
    if (!blob) return Error{file.string(), blob.error().what};
    const Result<BlobHead> head = blob_head(*blob);
    if (!head) return Error{file.string(), head.error().what};
    const VisibilityField& field = head->field;
    return FieldCard{
        field.entity,        field.keys,  field.bounds, head->planar_samples, head->spherical_samples,
        head->local_samples, field.error, sealed};
}

Result<FieldVerdict> verify_field(const path& file, Unsealed unsealed) {
    HF_TRY(const OpenedField opened, opened_field(file, unsealed));
    if (!opened.sealed || !same_vdb_library(opened.file.bytes)) return FieldVerdict{opened.sealed, false};
    const Result<VdbFile> made = vdb_file(opened.field);
    if (!made) return Error{file.string(), made.error().what};
    if (opened.file.bytes.substr(0, opened.file.bytes.size() - field_seal_size) != made->bytes)
        return Error{file.string(), "its grids do not match its field"};
    return FieldVerdict{true, true};
}

}  // namespace haarfield
