#include "fields/field/field_file.h"

#include "fields/field/ambient_visibility.h"
#include "fields/field/field_grids.h"
#include "fields/field/field_transfer.h"
#include "fields/file/input_file.h"
#include "fields/file/temporary_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace haarfield {
namespace {

using std::filesystem::path;

Result<MappedFile> transferred(const path& file, FieldContent content) {
    HF_TRY(const InputFile opened, InputFile::open(file));
    return guarded_field(opened.descriptor(), content, file.string());
}

/// Compares a grid with the values of a volume: value(i) are those of voxel i.
template <class Value>
Result<Done> compare_grid(const path& file, const char* name, const AmbientVisibility& volume,
                          std::size_t components, const Value& value) {
    constexpr float tolerance = 1e-5f;
    HF_TRY(const VdbLeaves leaves, read_vdb_leaves(file, name));
    const auto differs = [&](std::array<std::int32_t, 3> at, const float* stored) {
        for (std::size_t k = 0; k < 3; ++k)
            if (at[k] < 0 || at[k] >= volume.size[k]) return true;
        const auto i = (std::size_t(at[0]) * std::size_t(volume.size[1]) + std::size_t(at[1])) *
                           std::size_t(volume.size[2]) +
                       std::size_t(at[2]);
        for (std::size_t c = 0; c < components; ++c)
            if (!(std::abs(stored[c] - value(i)[c]) <= tolerance)) return true;
        return false;
    };
    bool is_equal = leaves.type == VdbLeaves::Type::floats && leaves.components == components;
    if (is_equal)
        for_each_active(leaves, [&](const std::array<std::int32_t, 3>& at, const float* stored) {
            is_equal = is_equal && !differs(at, stored);
        });
    if (is_equal) return Done{};
    return Error{file.string(), fmt::format("grid \"{}\": does not match the field", name)};
}

}  // namespace

Result<Done> write_field(const VisibilityField& field, const path& file) {
    const std::string where = file.string();
    if (const std::string defect = field_defect(field); !defect.empty())
        return Error{where, "the field has a defect and was not written: " + defect};
    const Result<std::string> bytes = field_file_bytes(field);
    if (!bytes) return Error{where, bytes.error().what};
    HF_TRY(TemporaryFile temporary, TemporaryFile::beside(file));
    HF_TRY_DONE(temporary.write(*bytes));
    return temporary.replace_target(*bytes);
}

Result<VisibilityField> read_field(const path& file) {
    HF_TRY(const MappedFile bytes, transferred(file, FieldContent::whole));
    Result<VisibilityField> field = transferred_field(bytes);
    if (!field) return Error{file.string(), field.error().what};
    if (const std::string defect = field_defect(*field); !defect.empty()) return Error{file.string(), defect};
    return field;
}

Result<FieldSummary> read_field_summary(const path& file) {
    HF_TRY(const VisibilityField field, read_field(file));
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
    std::error_code unknown;
    summary.file_bytes = std::filesystem::file_size(file, unknown);
    return summary;
}

bool is_field(const VdbListing& listing) {
    return std::ranges::any_of(listing.grids, [](const VdbGrid& grid) {
        return std::ranges::any_of(grid.metadata,
                                   [](const VdbMetadata& meta) { return meta.name == "haarfield_version"; });
    });
}

Result<FieldCard> read_field_card(const path& file) {
    HF_TRY(const MappedFile bytes, transferred(file, FieldContent::head));
    const Result<FieldHead> head = transferred_head(bytes.bytes);
    if (!head) return Error{file.string(), head.error().what};
    const VisibilityField& field = head->field;
    return FieldCard{field.entity,           field.keys,         field.bounds, head->counts.planar,
                     head->counts.spherical, head->counts.local, field.error};
}

Result<Done> verify_field(const path& file) {
    HF_TRY(const VisibilityField field, read_field(file));
    const AmbientVisibility volume = ambient_visibility(field);
    HF_TRY_DONE(compare_grid(file, "ambient_visibility", volume, 1,
                             [&](std::size_t i) { return std::array{volume.values[i]}; }));
    return compare_grid(file, "open_direction", volume, 3, [&](std::size_t i) {
        const Vec3f& mean = volume.directions[i];
        return std::array{mean.x, mean.y, mean.z};
    });
}

}  // namespace haarfield
