#include "fields/field/field_transfer.h"

namespace haarfield {
namespace {

constexpr std::uint64_t alignment = 64;

std::uint64_t padded(std::uint64_t bytes) {
    return (bytes + alignment - 1) / alignment * alignment;
}

Error wrong_size() {
    return {"", "the reader process returned tables of the wrong size"};
}

/// Takes tables from the front of some bytes.
class TableSource {
public:
    TableSource(std::string_view bytes, std::shared_ptr<const void> owner)
        : rest_(bytes), owner_(std::move(owner)) {}

    /// Returns a table in place; an empty one on failure.
    template <class T>
    SharedArray<T> table(std::uint64_t count) {
        if (count > rest_.size() / sizeof(T)) good_ = false;
        const std::uint64_t bytes = good_ ? count * sizeof(T) : 0;
        if (padded(bytes) > rest_.size()) good_ = false;
        if (!good_) return {};
        const std::span elements(reinterpret_cast<const T*>(rest_.data()), static_cast<std::size_t>(count));
        rest_.remove_prefix(padded(bytes));
        return {elements, owner_};
    }
    template <class T>
    std::vector<T> copy(std::uint64_t count) {
        const SharedArray<T> values = table<T>(count);
        return {values.begin(), values.end()};
    }
    bool is_at_end() const { return good_ && rest_.empty(); }

private:
    std::string_view rest_;
    std::shared_ptr<const void> owner_;
    bool good_ = true;
};

/// Returns the padded size of the head, with its length before it; 0 if it is longer than the bytes.
std::uint64_t head_size(std::string_view bytes) {
    const auto size = ByteSource(bytes).value<std::uint64_t>();
    if (bytes.size() < sizeof size || size > bytes.size() - sizeof size) return 0;
    return padded(sizeof size + size) > bytes.size() ? 0 : padded(sizeof size + size);
}

}  // namespace

void write_field_head(const FieldHead& head, ByteSink& sink) {
    const std::string bytes = written_bytes([&](ByteSink& members) {
        const VisibilityField& field = head.field;
        members.text(field.entity);
        members.value(field.keys);
        members.value(field.settings);
        members.value(field.bounds);
        members.value(field.planar);
        members.value(field.spherical);
        members.value(field.error);
        members.value(head.counts);
    });
    sink.text(bytes);
    write_field_padding(sizeof(std::uint64_t) + bytes.size(), sink);
}

void write_field_padding(std::uint64_t table_bytes, ByteSink& sink) {
    sink.bytes(std::string(static_cast<std::size_t>(padded(table_bytes) - table_bytes), '\0'));
}

Result<FieldHead> transferred_head(std::string_view bytes) {
    if (head_size(bytes) == 0) return wrong_size();
    const std::string members = ByteSource(bytes).text();
    ByteSource source(members);
    FieldHead head;
    VisibilityField& field = head.field;
    field.entity = source.text();
    field.keys = source.value<FieldKeys>();
    field.settings = source.value<FieldSettings>();
    field.bounds = source.value<Bounds>();
    field.planar = source.value<PlanarSampler>();
    field.spherical = source.value<SphericalSampler>();
    field.error = source.value<FieldError>();
    head.counts = source.value<FieldCounts>();
    field.pool.face_size = field.settings.face_size;
    if (!source.is_at_end()) return wrong_size();
    return head;
}

Result<VisibilityField> transferred_field(const MappedFile& bytes) {
    HF_TRY(FieldHead head, transferred_head(bytes.bytes));
    VisibilityField field = std::move(head.field);
    TableSource source(bytes.bytes.substr(head_size(bytes.bytes)), bytes.owner);
    field.pool.cubemaps = source.table<PackedCubemap>(head.counts.cubemaps);
    field.pool.faces = source.table<PackedFace>(head.counts.faces);
    field.pool.node_bytes = source.table<std::uint8_t>(head.counts.node_bytes);
    field.planar_handles = source.copy<std::int32_t>(head.counts.planar);
    field.spherical_handles = source.copy<std::int32_t>(head.counts.spherical);
    field.local_handles = source.copy<std::int32_t>(head.counts.local);
    if (!source.is_at_end()) return wrong_size();
    return field;
}

}  // namespace haarfield
