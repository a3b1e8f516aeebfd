#include "fields/field/sample_run.h"

#include <algorithm>
#include <cstring>

namespace haarfield {
namespace {

template <class Values>
std::string bytes_of(const Values& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(*values.data())};
}

/// Reads a section's elements. False if it is missing or its size is not a multiple of theirs.
template <class T>
bool read_values(const std::vector<Section>& sections, const char* name, std::vector<T>& values) {
    const std::string* const bytes = section_named(sections, name);
    if (!bytes || bytes->size() % sizeof(T) != 0) return false;
    values.resize(bytes->size() / sizeof(T));
    if (!bytes->empty()) std::memcpy(values.data(), bytes->data(), bytes->size());
    return true;
}

std::string keys_text(const FieldKeys& keys) {
    return "2 " + keys.surroundings.hex() + keys.whole.hex();  // 2: version of the tables
}

}  // namespace

std::vector<Section> sample_sections(const SampleRun& run, const FieldKeys& keys) {
    return {{"keys", keys_text(keys)},
            {"numbers", bytes_of(std::array<std::uint64_t, 2>{run.first, std::uint64_t(run.pool.face_size)})},
            {"handles", bytes_of(run.handles)},
            {"cubemaps", bytes_of(run.pool.cubemaps)},
            {"faces", bytes_of(run.pool.faces)},
            {"nodes", bytes_of(run.pool.node_bytes)}};
}

Result<SampleRun> sections_samples(const std::vector<Section>& sections, const FieldKeys& keys) {
    const std::string* const made_for = section_named(sections, "keys");
    if (!made_for || *made_for != keys_text(keys))
        return Error{"", "contains samples of another field: its mesh or settings have changed"};
    SampleRun run;
    std::vector<std::uint64_t> numbers;
    std::vector<PackedCubemap> cubemaps;
    std::vector<PackedFace> faces;
    std::vector<std::uint8_t> nodes;
    if (!read_values(sections, "numbers", numbers) || numbers.size() != 2 ||
        !read_values(sections, "handles", run.handles) || !read_values(sections, "cubemaps", cubemaps) ||
        !read_values(sections, "faces", faces) || !read_values(sections, "nodes", nodes))
        return Error{"", "a table of samples is missing or has the wrong size"};
    run.first = numbers[0];
    run.pool = {static_cast<int>(numbers[1]), std::move(nodes), std::move(faces), std::move(cubemaps)};
    if (std::string defect = pool_defect(run.pool); !defect.empty()) return Error{"", defect};
    const auto count = static_cast<std::int64_t>(run.pool.cubemaps.size());
    if (std::ranges::any_of(run.handles, [&](std::int32_t handle) { return handle < 0 || handle >= count; }))
        return Error{"", "a sample refers to a missing cubemap"};
    return run;
}

}  // namespace haarfield
