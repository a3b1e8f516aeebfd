#include "fields/field_blob.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <bit>
#include <cstring>

namespace haarfield {
namespace {

static_assert(std::endian::native == std::endian::little, "tables are stored as they lie in memory");

constexpr std::string_view blob_magic = "HAARBLOB", seal_magic = "HAARSEAL";
constexpr std::uint32_t blob_version = 3, seal_version = 1;

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

enum SectionIndex : std::size_t { entity, record, cubemaps, faces, nodes, section_count };

constexpr std::array<std::string_view, section_count> section_names{"entity", "record", "cubemaps", "faces",
                                                                    "nodes"};
constexpr std::size_t table_size = sizeof(BlobHeader) + section_count * sizeof(Section);

/// Words of four bytes only, so that there is no padding.
struct FieldRecord {
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
    float planar_error, spherical_error;
};
static_assert(sizeof(FieldRecord) == 28 * 4);

struct Seal {
    char magic[8];
    std::uint32_t version, zero;
    std::uint64_t file_bytes;
    std::array<std::uint64_t, 2> key, content;
    std::uint64_t hash;
};
static_assert(sizeof(Seal) == field_seal_size);
constexpr std::size_t hashed_seal_size = offsetof(Seal, hash);

std::array<float, 3> words(const Vec3f& v) {
    return {v.x, v.y, v.z};
}

Vec3f vector(const std::array<float, 3>& words) {
    return {words[0], words[1], words[2]};
}

FieldRecord field_record(const VisibilityField& field) {
    const PlanarSampler& planar = field.planar;
    const SphericalSampler& spherical = field.spherical;
    return {field.settings.face_size,
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

/// Bytes of a struct or of the elements of an array.
template <class T>
std::string_view bytes_of(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    return {reinterpret_cast<const char*>(&value), sizeof value};
}

template <class T>
std::string_view bytes_of(const SharedArray<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

template <class T>
T value_at(std::string_view bytes, std::size_t offset) {
    T value;
    std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
}

/// Whether the bytes are a whole number of elements.
template <class T>
bool read_table(std::string_view bytes, SharedArray<T>& table) {
    if (bytes.size() % sizeof(T) != 0) return false;
    std::vector<T> values(bytes.size() / sizeof(T));
    if (!bytes.empty()) std::memcpy(values.data(), bytes.data(), bytes.size());
    table = std::move(values);
    return true;
}

std::uint64_t short_hash(std::string_view bytes) {
    return XXH3_64bits(bytes.data(), bytes.size());
}

template <std::size_t size>
void set_name(char (&name)[size], std::string_view text) {
    std::memset(name, 0, size);
    std::memcpy(name, text.data(), text.size());
}

/// The blob's sections, once header, table and checksums hold.
Result<std::array<std::string_view, section_count>> checked_sections(std::string_view blob) {
    if (blob.size() < table_size + sizeof(std::uint64_t))
        return Error{"", "the field's tables are cut short"};
    const auto header = value_at<BlobHeader>(blob, 0);
    if (std::string_view(header.magic, sizeof header.magic) != blob_magic)
        return Error{"", "the field's tables do not begin with " + std::string(blob_magic)};
    if (header.version != blob_version)
        return Error{"", fmt::format("the field has version {}; wanted {}", header.version, blob_version)};
    if (header.sections != section_count || header.bytes != blob.size())
        return Error{"", "the field's tables have another size or number than they say"};
    if (value_at<std::uint64_t>(blob, table_size) != short_hash(blob.substr(0, table_size)))
        return Error{"", "the checksum of the field's list of tables is wrong"};

    std::array<std::string_view, section_count> sections;
    std::uint64_t offset = table_size + sizeof(std::uint64_t);
    for (std::size_t s = 0; s < section_count; ++s) {
        const auto section = value_at<Section>(blob, sizeof(BlobHeader) + s * sizeof(Section));
        char name[sizeof section.name];
        set_name(name, section_names[s]);
        if (std::memcmp(section.name, name, sizeof name) != 0 || section.offset != offset ||
            section.bytes > blob.size() - offset)
            return Error{
                "", fmt::format("table \"{}\" of the field is not where it should be", section_names[s])};
        sections[s] = blob.substr(offset, section.bytes);
        if (short_hash(sections[s]) != section.hash)
            return Error{"",
                         fmt::format("the checksum of table \"{}\" of the field is wrong", section_names[s])};
        offset += section.bytes;
    }
    if (offset != blob.size()) return Error{"", "something follows the last of the field's tables"};
    return sections;
}

}  // namespace

std::string field_blob(const VisibilityField& field) {
    const FieldRecord words_of_field = field_record(field);
    std::array<std::string_view, section_count> sections;
    sections[entity] = field.entity;
    sections[record] = bytes_of(words_of_field);
    sections[cubemaps] = bytes_of(field.pool.cubemaps);
    sections[faces] = bytes_of(field.pool.faces);
    sections[nodes] = bytes_of(field.pool.node_bytes);

    BlobHeader header{};
    set_name(header.magic, blob_magic);
    header.version = blob_version;
    header.sections = section_count;
    header.bytes = table_size + sizeof(std::uint64_t);
    std::array<Section, section_count> table{};
    for (std::size_t s = 0; s < section_count; ++s) {
        set_name(table[s].name, section_names[s]);
        table[s].offset = header.bytes;
        table[s].bytes = sections[s].size();
        table[s].hash = short_hash(sections[s]);
        header.bytes += sections[s].size();
    }
    std::string blob;
    blob.reserve(header.bytes);
    blob += bytes_of(header);
    blob += bytes_of(table);
    blob += bytes_of(short_hash(blob));
    for (const std::string_view section : sections) blob += section;
    return blob;
}

Result<VisibilityField> blob_field(std::string_view blob) {
    const auto sections = checked_sections(blob);
    if (!sections) return sections.error();
    VisibilityField field;
    field.entity = (*sections)[entity];
    if ((*sections)[record].size() != sizeof(FieldRecord))
        return Error{"", fmt::format("table \"record\" of the field has {} bytes; wanted {}",
                                     (*sections)[record].size(), sizeof(FieldRecord))};
    apply_record(value_at<FieldRecord>((*sections)[record], 0), field);
    if (!read_table((*sections)[cubemaps], field.pool.cubemaps) ||
        !read_table((*sections)[faces], field.pool.faces) ||
        !read_table((*sections)[nodes], field.pool.node_bytes))
        return Error{"", "a table of the field ends within an element"};
    return field;
}

ContentHash content_hash(std::string_view bytes) {
    const XXH128_hash_t hash = XXH3_128bits(bytes.data(), bytes.size());
    return {hash.low64, hash.high64};
}

std::string field_seal(std::string_view file, const ContentHash& key) {
    const ContentHash content = content_hash(file);
    Seal seal{};
    set_name(seal.magic, seal_magic);
    seal.version = seal_version;
    seal.file_bytes = file.size() + sizeof(Seal);
    seal.key = {key.low, key.high};
    seal.content = {content.low, content.high};
    seal.hash = short_hash(bytes_of(seal).substr(0, hashed_seal_size));
    return std::string(bytes_of(seal));
}

Result<FieldSeal> read_field_seal(std::string_view end, std::uint64_t file_bytes) {
    const auto no_seal = Error{"", "no seal at its end: cut short, saved by another program, or not a field"};
    if (end.size() != sizeof(Seal)) return no_seal;
    const auto seal = value_at<Seal>(end, 0);
    if (std::string_view(seal.magic, sizeof seal.magic) != seal_magic) return no_seal;
    if (seal.version != seal_version)
        return Error{"", fmt::format("the seal has version {}; wanted {}", seal.version, seal_version)};
    if (seal.hash != short_hash(end.substr(0, hashed_seal_size))) return Error{"", "the seal is damaged"};
    if (seal.file_bytes != file_bytes)
        return Error{"", fmt::format("{} bytes long; sealed with {}", file_bytes, seal.file_bytes)};
    return FieldSeal{{seal.key[0], seal.key[1]}, {seal.content[0], seal.content[1]}};
}

}  // namespace haarfield
