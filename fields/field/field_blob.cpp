#include "fields/field/field_blob.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <bit>
#include <cstring>
#include <span>

namespace haarfield {
namespace {

static_assert(std::endian::native == std::endian::little, "tables are stored as they lie in memory");

constexpr std::string_view blob_magic = "HAARBLOB";

struct BlobHeader {
    char magic[8];
    std::uint32_t version, sections;
    std::uint64_t bytes;
};
static_assert(sizeof(BlobHeader) == 24);

struct Section {
    char name[8];
    std::uint64_t offset, bytes, hash;
};
static_assert(sizeof(Section) == 32);

enum SectionIndex : std::size_t {
    entity,
    record,
    planar_table,
    spherical_table,
    local_table,
    cubemaps,
    faces,
    nodes,
    section_count
};

constexpr std::array<std::string_view, section_count> section_names{"entity", "record",   "planar", "spheric",
                                                                    "local",  "cubemaps", "faces",  "nodes"};
constexpr std::size_t table_size = sizeof(BlobHeader) + section_count * sizeof(Section);
constexpr std::size_t head_size = table_size + sizeof(std::uint64_t);

using Sections = std::array<std::string_view, section_count>;

/// The section "record". It has words of four bytes only, so that the compiler adds no padding.
struct FieldRecord {
    std::array<std::uint32_t, 8> keys;  ///< FieldKeys: surroundings, whole; low words first.
    std::int32_t face_size, coefficients;
    float relative_l2_error;
    std::uint32_t planar_samples, spherical_samples;
    std::array<float, 3> lower, upper;
    std::array<float, 3> planar_centre;
    std::int32_t rings, angles;
    float planar_outer_radius, planar_growth;
    std::array<float, 3> spherical_centre;
    std::int32_t shells, polar, azimuths;
    float spherical_outer_radius, spherical_growth;
    SamplerError planar_error, spherical_error;
};
static_assert(sizeof(FieldRecord) == (34 + 2 * (1 + SamplerError::bands)) * 4);

std::array<float, 3> words(const Vec3f& v) {
    return {v.x, v.y, v.z};
}

Vec3f vector(const std::array<float, 3>& words) {
    return {words[0], words[1], words[2]};
}

FieldRecord field_record(const VisibilityField& field) {
    const PlanarSampler& planar = field.planar;
    const SphericalSampler& spherical = field.spherical;
    const auto& [around, whole] = field.keys;
    return {std::bit_cast<std::array<std::uint32_t, 8>>(
                std::array{around.low, around.high, whole.low, whole.high}),
            field.settings.face_size,
            field.settings.coefficients,
            field.settings.relative_l2_error,
            field.settings.planar_samples,
            field.settings.spherical_samples,
            words(field.bounds.lower),
            words(field.bounds.upper),
            words(planar.centre),
            planar.rings,
            planar.angles,
            planar.outer_radius,
            planar.growth,
            words(spherical.centre),
            spherical.shells,
            spherical.polar,
            spherical.azimuths,
            spherical.outer_radius,
            spherical.growth,
            field.error.planar,
            field.error.spherical};
}

void apply_record(const FieldRecord& record, VisibilityField& field) {
    const auto keys = std::bit_cast<std::array<std::uint64_t, 4>>(record.keys);
    field.keys = {{keys[0], keys[1]}, {keys[2], keys[3]}};
    field.settings = {record.face_size, record.coefficients, record.relative_l2_error, record.planar_samples,
                      record.spherical_samples};
    field.bounds = {vector(record.lower), vector(record.upper)};
    field.planar = {vector(record.planar_centre), record.rings, record.angles, record.planar_outer_radius,
                    record.planar_growth};
    field.spherical = {vector(record.spherical_centre), record.shells,          record.polar, record.azimuths,
                       record.spherical_outer_radius,   record.spherical_growth};
    field.error = {record.planar_error, record.spherical_error};
    field.pool.face_size = record.face_size;
}

std::size_t aligned(std::size_t offset) {
    return (offset + field_blob_alignment - 1) / field_blob_alignment * field_blob_alignment;
}

/// The bytes of a struct, or of the elements of an array.
template <class T>
std::string_view bytes_of(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    return {reinterpret_cast<const char*>(&value), sizeof value};
}

template <class T>
std::string_view bytes_of(std::span<const T> values) {
    static_assert(std::is_trivially_copyable_v<T>);
    return {reinterpret_cast<const char*>(values.data()), values.size_bytes()};
}

template <class T>
T value_at(std::string_view bytes, std::size_t offset) {
    T value;
    std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
}

std::uint64_t short_hash(std::string_view bytes) {
    return XXH3_64bits(bytes.data(), bytes.size());
}

template <std::size_t size>
void set_name(char (&name)[size], std::string_view text) {
    std::memset(name, 0, size);
    std::memcpy(name, text.data(), text.size());
}

/// Returns the header of the blob at the start of some bytes, after verifying its checksum.
Result<BlobHeader> checked_header(std::string_view bytes) {
    if (!bytes.starts_with(blob_magic))
        return Error{"", "the field's tables do not begin with " + std::string(blob_magic)};
    if (bytes.size() < head_size) return Error{"", "the field's tables are cut short"};
    const auto header = value_at<BlobHeader>(bytes, 0);
    if (header.version != field_blob_version)
        return Error{
            "", fmt::format("the field has version {}; expected {}", header.version, field_blob_version)};
    if (value_at<std::uint64_t>(bytes, table_size) != short_hash(bytes.substr(0, table_size)))
        return Error{"", "the checksum of the field's list of tables is wrong"};
    return header;
}

/// Returns the sections of a blob, after verifying its header and the checksums of the first `checked`
/// sections.
Result<Sections> checked_sections(std::string_view blob, std::size_t checked = section_count) {
    HF_TRY(const BlobHeader header, checked_header(blob));
    if (header.sections != section_count || header.bytes != blob.size())
        return Error{"", "the size or number of the field's tables differs from that in their header"};
    Sections sections;
    std::uint64_t end = head_size;
    for (std::size_t s = 0; s < section_count; ++s) {
        const auto section = value_at<Section>(blob, sizeof(BlobHeader) + s * sizeof(Section));
        char name[sizeof section.name];
        set_name(name, section_names[s]);
        if (std::memcmp(section.name, name, sizeof name) != 0 || section.offset != aligned(end) ||
            section.offset > blob.size() || section.bytes > blob.size() - section.offset)
            return Error{
                "", fmt::format("table \"{}\" of the field is not at its expected place", section_names[s])};
        if (blob.substr(end, section.offset - end).find_first_not_of('\0') != std::string_view::npos)
            return Error{"",
                         fmt::format("unexpected bytes before table \"{}\" of the field", section_names[s])};
        sections[s] = blob.substr(section.offset, section.bytes);
        if (s < checked && short_hash(sections[s]) != section.hash)
            return Error{"",
                         fmt::format("the checksum of table \"{}\" of the field is wrong", section_names[s])};
        end = section.offset + section.bytes;
    }
    if (end != blob.size()) return Error{"", "unexpected bytes after the last table of the field"};
    return sections;
}

/// Copies the elements of a section. Returns false if the section ends within an element.
template <class T>
bool read_values(std::string_view bytes, std::vector<T>& values) {
    if (bytes.size() % sizeof(T) != 0) return false;
    values.resize(bytes.size() / sizeof(T));
    if (!bytes.empty()) std::memcpy(values.data(), bytes.data(), bytes.size());
    return true;
}

/// Like read_values, but refers to elements that are aligned in memory instead of copying them.
template <class T>
bool read_table(std::string_view bytes, const std::shared_ptr<const void>& owner, SharedArray<T>& table) {
    if (bytes.size() % sizeof(T) == 0 && reinterpret_cast<std::uintptr_t>(bytes.data()) % alignof(T) == 0) {
        table = {std::span(reinterpret_cast<const T*>(bytes.data()), bytes.size() / sizeof(T)), owner};
        return true;
    }
    std::vector<T> values;
    if (!read_values(bytes, values)) return false;
    table = std::move(values);
    return true;
}

/// Returns the field without handles and pool.
Result<VisibilityField> described_field(const Sections& sections) {
    VisibilityField field;
    field.entity = sections[entity];
    if (sections[record].size() != sizeof(FieldRecord))
        return Error{"", fmt::format("table \"record\" of the field has {} bytes; expected {}",
                                     sections[record].size(), sizeof(FieldRecord))};
    apply_record(value_at<FieldRecord>(sections[record], 0), field);
    return field;
}

}  // namespace

std::string field_blob(const VisibilityField& field) {
    const FieldRecord words_of_field = field_record(field);
    const QuadtreePool& pool = field.pool;
    Sections sections;
    sections[entity] = field.entity;
    sections[record] = bytes_of(words_of_field);
    sections[planar_table] = bytes_of(std::span(field.planar_handles));
    sections[spherical_table] = bytes_of(std::span(field.spherical_handles));
    sections[local_table] = bytes_of(std::span(field.local_handles));
    sections[cubemaps] = bytes_of(std::span(pool.cubemaps.data(), pool.cubemaps.size()));
    sections[faces] = bytes_of(std::span(pool.faces.data(), pool.faces.size()));
    sections[nodes] = bytes_of(std::span(pool.node_bytes.data(), pool.node_bytes.size()));

    BlobHeader header{};
    set_name(header.magic, blob_magic);
    header.version = field_blob_version;
    header.sections = section_count;
    header.bytes = head_size;
    std::array<Section, section_count> table{};
    for (std::size_t s = 0; s < section_count; ++s) {
        set_name(table[s].name, section_names[s]);
        table[s].offset = aligned(header.bytes);
        table[s].bytes = sections[s].size();
        table[s].hash = short_hash(sections[s]);
        header.bytes = table[s].offset + table[s].bytes;
    }
    std::string blob;
    blob.reserve(header.bytes);
    blob += bytes_of(header);
    blob += bytes_of(table);
    blob += bytes_of(short_hash(blob));
    for (const std::string_view section : sections) {
        blob.resize(aligned(blob.size()));
        blob += section;
    }
    return blob;
}

Result<VisibilityField> blob_field(std::string_view blob, const std::shared_ptr<const void>& owner) {
    HF_TRY(const Sections sections, checked_sections(blob));
    Result<VisibilityField> field = described_field(sections);
    if (!field) return field;
    if (!read_values(sections[planar_table], field->planar_handles) ||
        !read_values(sections[spherical_table], field->spherical_handles) ||
        !read_values(sections[local_table], field->local_handles) ||
        !read_table(sections[cubemaps], owner, field->pool.cubemaps) ||
        !read_table(sections[faces], owner, field->pool.faces) ||
        !read_table(sections[nodes], owner, field->pool.node_bytes))
        return Error{"", "a table of the field ends within an element"};
    return field;
}

Result<BlobHead> blob_head(std::string_view blob) {
    HF_TRY(const Sections sections, checked_sections(blob, record + 1));
    HF_TRY(VisibilityField field, described_field(sections));
    const auto count = [&](std::size_t table) { return sections[table].size() / sizeof(std::int32_t); };
    return BlobHead{std::move(field), count(planar_table), count(spherical_table), count(local_table)};
}

std::string_view find_field_blob(std::string_view file) {
    for (std::size_t begin = file.find(blob_magic); begin != std::string_view::npos;
         begin = file.find(blob_magic, begin + 1)) {
        const std::string_view rest = file.substr(begin);
        if (const Result<BlobHeader> header = checked_header(rest); header && header->bytes <= rest.size())
            return rest.substr(0, header->bytes);
    }
    return {};
}

}  // namespace haarfield
