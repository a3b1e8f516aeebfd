#include "fields/field/field_seal.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <cstddef>
#include <cstring>

namespace haarfield {
namespace {

constexpr std::string_view seal_magic = "HAARSEAL";
constexpr std::uint32_t seal_version = 2;

struct Seal {
    char magic[8];
    std::uint32_t version, zero;
    std::uint64_t file_bytes, blob_offset, blob_bytes;
    std::array<std::uint64_t, 2> content;
    std::uint64_t hash;
};
static_assert(sizeof(Seal) == field_seal_size);

std::uint64_t seal_hash(const Seal& seal) {
    return XXH3_64bits(&seal, offsetof(Seal, hash));
}

}  // namespace

ContentHash content_hash(std::string_view bytes) {
    const XXH128_hash_t hash = XXH3_128bits(bytes.data(), bytes.size());
    return {hash.low64, hash.high64};
}

std::string field_seal(std::string_view file, std::string_view blob) {
    const ContentHash content = content_hash(file);
    Seal seal{};
    std::memcpy(seal.magic, seal_magic.data(), sizeof seal.magic);
    seal.version = seal_version;
    seal.file_bytes = file.size() + sizeof(Seal);
    seal.blob_offset = static_cast<std::uint64_t>(blob.data() - file.data());
    seal.blob_bytes = blob.size();
    seal.content = {content.low, content.high};
    seal.hash = seal_hash(seal);
    return {reinterpret_cast<const char*>(&seal), sizeof seal};
}

bool has_field_seal(std::string_view file) {
    return file.size() >= sizeof(Seal) && file.substr(file.size() - sizeof(Seal)).starts_with(seal_magic);
}

Result<FieldSeal> read_field_seal(std::string_view file) {
    if (!has_field_seal(file))
        return Error{"", "no seal at its end: cut short, saved by another program, or not a field"};
    Seal seal;
    const std::uint64_t before = file.size() - sizeof seal;
    std::memcpy(&seal, file.data() + before, sizeof seal);
    if (seal.version != seal_version)
        return Error{"", fmt::format("the seal has version {}; expected {}", seal.version, seal_version)};
    if (seal.hash != seal_hash(seal)) return Error{"", "the seal is damaged"};
    if (seal.file_bytes != file.size())
        return Error{"", fmt::format("{} bytes long; the seal expects {}", file.size(), seal.file_bytes)};
    if (seal.blob_offset > before || seal.blob_bytes > before - seal.blob_offset)
        return Error{"", "the field's tables are outside the file, according to the seal"};
    return FieldSeal{seal.blob_offset, seal.blob_bytes, {seal.content[0], seal.content[1]}};
}

}  // namespace haarfield
