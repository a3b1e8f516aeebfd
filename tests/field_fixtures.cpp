#include "tests/field_fixtures.h"

#include <gtest/gtest.h>
#include <xxhash.h>

#include <cstring>
#include <random>

#include "fields/field_precompute.h"
#include "fields/field_seal.h"
#include "tests/example_meshes.h"

namespace haarfield {

const VisibilityField& example_field() {
    static const VisibilityField field = [] {
        const PreparedMesh mesh = prepared_as_is(joined_meshes(
            box_mesh({-0.5f, 0, -0.5f}, {0.5f, 1, 0.5f}, 3), sphere_mesh({0, 1.2f, 0}, 0.4f, 8)));
        return *precompute_field("a chair: \xc3\xa9", mesh, EntityOcclusion(mesh), {16, 10, 0, 100, 150});
    }();
    return field;
}

VisibilityField random_field(std::uint32_t seed, std::size_t vertices) {
    std::mt19937 random(seed);
    const auto below = [&](std::uint32_t limit) { return static_cast<std::uint32_t>(random() % limit); };
    const auto number = [&] { return static_cast<float>(below(2001)) / 1000 - 1; };
    QuadtreePoolBuilder pool(32);
    PackedTrees packed;
    for (int i = 0; i < 50; ++i) {
        CubemapTree cubemap;
        for (Quadtree& face : cubemap.faces) {
            face.scaling = number();
            if (below(2) == 0) continue;
            face.nodes.resize(5);
            for (Quadtree::Node& node : face.nodes) node.wavelet = {number() / 2, number() / 2, number() / 2};
            face.nodes[0].children = 1u << 4 | 15u;
        }
        pack_trees(cubemap, packed);
        pool.add(packed);
    }
    VisibilityField field;
    field.pool = std::move(pool).finish();
    field.entity = seed % 2 ? std::string() : std::string("nul \0 and \n", 11);
    field.key = {random() * 0x100000001ull, random() * 0x100000003ull};
    field.settings = {32, static_cast<std::int32_t>(below(100)), number() * number(), below(1000),
                      below(1000)};
    field.error.planar.relative = 0.25f;
    for (float& band : field.error.spherical.band) band = static_cast<float>(below(1001)) / 1000;
    field.bounds = {Vec3f(-1, number(), -3), Vec3f(2 + number(), 2, -0.0f)};
    const auto count = [&](std::int32_t least) { return static_cast<std::int32_t>(below(20)) + least; };
    field.planar = {Vec3f(number(), number(), number()), count(2), count(3), 1.5f, 2.5f};
    field.spherical = {Vec3f(number(), number(), number()), count(2), count(3), count(3), 1.25f, 0.5f};
    const auto handle = [&] { return static_cast<std::int32_t>(below(50)); };
    field.planar_handles.resize(field.planar.sample_count());
    field.spherical_handles.resize(field.spherical.sample_count());
    field.local_handles.resize(vertices);
    for (auto* handles : {&field.planar_handles, &field.spherical_handles, &field.local_handles})
        std::generate(handles->begin(), handles->end(), handle);
    return field;
}

namespace {

template <class T>
bool same_bits(const T& a, const T& b) {
    return std::memcmp(&a, &b, sizeof a) == 0;
}

}  // namespace

void expect_same(const VisibilityField& a, const VisibilityField& b, const std::string& which) {
    SCOPED_TRACE(which);
    EXPECT_EQ(a.entity, b.entity);
    EXPECT_EQ(a.key, b.key);
    EXPECT_TRUE(same_bits(a.settings, b.settings));
    EXPECT_TRUE(same_bits(a.bounds, b.bounds));
    EXPECT_TRUE(same_bits(a.planar, b.planar));
    EXPECT_TRUE(same_bits(a.spherical, b.spherical));
    EXPECT_EQ(a.planar_handles, b.planar_handles);
    EXPECT_EQ(a.spherical_handles, b.spherical_handles);
    EXPECT_EQ(a.local_handles, b.local_handles);
    EXPECT_EQ(a.error, b.error);
    EXPECT_EQ(a.pool.face_size, b.pool.face_size);
    EXPECT_EQ(a.pool.node_bytes, b.pool.node_bytes);
    EXPECT_EQ(a.pool.faces, b.pool.faces);
    EXPECT_EQ(a.pool.cubemaps, b.pool.cubemaps);
}

namespace {

/// The layout that field_blob.h describes.
constexpr std::size_t section_count = 8, header_size = 24, entry_size = 32,
                      list_size = header_size + section_count * entry_size;

std::uint64_t word(const VdbFile& file, std::size_t offset_in_blob) {
    std::uint64_t value;
    std::memcpy(&value, file.bytes.data() + file.blob_offset + offset_in_blob, sizeof value);
    return value;
}

}  // namespace

std::size_t section_offset(const VdbFile& file, std::size_t section) {
    return file.blob_offset + word(file, header_size + entry_size * section + 8);
}

std::string forged_file(VdbFile file) {
    const auto set_hash = [&](std::size_t at, std::uint64_t from, std::uint64_t size) {
        if (from > file.blob_bytes || size > file.blob_bytes - from) return;
        const std::uint64_t hash = XXH3_64bits(file.blob().data() + from, size);
        std::memcpy(file.bytes.data() + file.blob_offset + at, &hash, sizeof hash);
    };
    for (std::size_t s = 0; s < section_count; ++s) {
        const std::size_t entry = header_size + entry_size * s;
        set_hash(entry + 24, word(file, entry + 8), word(file, entry + 16));
    }
    set_hash(list_size, 0, list_size);
    return file.bytes + field_seal(file.bytes, file.blob());
}

}  // namespace haarfield
