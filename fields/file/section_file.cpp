#include "fields/file/section_file.h"

#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <optional>

#include "fields/file/mapped_file.h"

namespace haarfield {
namespace {

constexpr std::string_view magic = "HAARPART";
constexpr std::uint32_t version = 1;
constexpr std::size_t head_size = 16, hash_size = 16;

template <class T>
void append(std::string& bytes, const T& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// Removes a value from the front; there must be enough bytes.
template <class T>
T taken(std::string_view& bytes) {
    T value;
    std::memcpy(&value, bytes.data(), sizeof value);
    bytes.remove_prefix(sizeof value);
    return value;
}

std::array<std::uint64_t, 2> hash_of(std::string_view bytes) {
    const XXH128_hash_t hash = XXH3_128bits(bytes.data(), bytes.size());
    return {hash.low64, hash.high64};
}

/// A section within the bytes of a file.
struct SectionView {
    std::string_view name, bytes;

    Section copy() const { return {std::string(name), std::string(bytes)}; }
};

/// Removes a section from the front; nothing if it is longer than the remaining bytes.
std::optional<SectionView> read_section(std::string_view& bytes) {
    if (bytes.size() < 2 * sizeof(std::uint64_t)) return std::nullopt;
    const auto name = taken<std::uint64_t>(bytes), size = taken<std::uint64_t>(bytes);
    if (name > bytes.size() || size > bytes.size() - name) return std::nullopt;
    const SectionView section{bytes.substr(0, name), bytes.substr(name, size)};
    bytes.remove_prefix(name + size);
    return section;
}

}  // namespace

std::string section_file(const std::vector<Section>& sections) {
    std::string bytes(magic);
    append(bytes, version);
    append(bytes, static_cast<std::uint32_t>(sections.size()));
    for (const Section& section : sections) {
        append(bytes, std::uint64_t(section.name.size()));
        append(bytes, std::uint64_t(section.bytes.size()));
        bytes += section.name;
        bytes += section.bytes;
    }
    append(bytes, hash_of(bytes));
    return bytes;
}

Result<std::vector<Section>> read_section_file(const std::filesystem::path& file) {
    HF_TRY(const MappedFile mapped, mapped_file(file, MappedPages::as_read));
    std::string_view bytes = mapped.bytes;
    const auto refusal = [&](const char* reason) { return Error{file.string(), reason}; };
    if (bytes.size() < head_size + hash_size || !bytes.starts_with(magic))
        return refusal("is cut short, or not a file of sections");
    HF_TRY_DONE(load_pages(mapped, file.string()));
    std::string_view end = bytes.substr(bytes.size() - hash_size);
    bytes.remove_suffix(hash_size);
    if (taken<std::array<std::uint64_t, 2>>(end) != hash_of(bytes))
        return refusal("is cut short or damaged: its checksum is wrong");
    bytes.remove_prefix(magic.size());
    if (taken<std::uint32_t>(bytes) != version) return refusal("has an unsupported version");
    std::vector<Section> sections;
    for (auto count = taken<std::uint32_t>(bytes); count > 0; --count) {
        const std::optional<SectionView> section = read_section(bytes);
        if (!section) return refusal("its sections are longer than the file");
        sections.push_back(section->copy());
    }
    if (!bytes.empty()) return refusal("has data after its last section");
    return sections;
}

Result<Section> read_first_section(const std::filesystem::path& file) {
    HF_TRY(const MappedFile mapped, mapped_file(file, MappedPages::as_read));
    std::string_view bytes = mapped.bytes;
    if (bytes.size() < head_size || !bytes.starts_with(magic))
        return Error{file.string(), "is cut short, or not a file of sections"};
    bytes.remove_prefix(magic.size() + sizeof version);
    const auto count = taken<std::uint32_t>(bytes);
    std::optional<SectionView> first = read_section(bytes), last = first;
    for (std::uint32_t taken = 1; last && taken < count; ++taken) last = read_section(bytes);
    if (count == 0 || !last || bytes.size() != hash_size)
        return Error{file.string(), "is cut short, or has data after its last section"};
    return first->copy();
}

const std::string* section_named(const std::vector<Section>& sections, std::string_view name) {
    const auto found = std::ranges::find(sections, name, &Section::name);
    return found == sections.end() ? nullptr : &found->bytes;
}

}  // namespace haarfield
