#include "fields/vdb/vdb_file.h"

#include <gtest/gtest.h>

#include <cstring>

#include "tests/fixtures/forged_grids.h"
#include "tests/fixtures/test_folder.h"

namespace haarfield {
namespace {

float number(const VdbLeaves& leaves, std::size_t i) {
    float value = 0;
    std::memcpy(&value, &leaves.values[i], sizeof value);
    return value;
}

/// A smoke grid with voxels in three leaves and one tile, and a grid of vectors.
openvdb::GridPtrVec example_grids() {
    openvdb::initialize();
    const auto smoke = openvdb::FloatGrid::create(0.25f);
    smoke->setName("density");
    smoke->setGridClass(openvdb::GRID_FOG_VOLUME);
    smoke->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
    smoke->insertMeta("author", openvdb::StringMetadata("nobody"));
    smoke->tree().setValueOn({1, 2, 3}, 4.0f);
    smoke->tree().setValueOn({-1, 0, 9}, 5.0f);
    smoke->tree().setValueOff({100, 0, 0}, 6.0f);
    smoke->tree().addTile(1, {16, 16, 16}, 7.0f, true);
    const auto wind = openvdb::Vec3DGrid::create();
    wind->setName("wind");
    wind->tree().setValueOn({0, 0, 0}, {1.0, 2.0, 3.0});
    const auto mask = openvdb::BoolGrid::create(false);
    mask->setName("mask");
    mask->tree().setValueOn({5, 5, 5}, true);
    const auto large = openvdb::Int64Grid::create();
    large->setName("large");
    return {smoke, wind, mask, large};
}

TEST(VdbFile, ListsGridsOfAnyProgram) {
    const TestFolder folder;
    write_text(folder / "smoke.vdb", file_of(example_grids()));
    const Result<VdbListing> listing = read_vdb_listing(folder / "smoke.vdb");
    ASSERT_TRUE(listing) << listing.error().message();
    EXPECT_NE(listing->version.find('/'), std::string::npos);
    ASSERT_EQ(listing->grids.size(), 4u);
    const VdbGrid& smoke = listing->grids[0];
    EXPECT_EQ(smoke.name, "density");
    EXPECT_EQ(smoke.type, "float");
    EXPECT_EQ(smoke.grid_class, "fog volume");
    EXPECT_EQ(smoke.active_voxels, 2u + 512u);
    EXPECT_EQ(smoke.leaves, 3u);
    EXPECT_EQ(smoke.lower, (std::array{-1, 0, 3}));
    EXPECT_EQ(smoke.upper, (std::array{23, 23, 23}));
    EXPECT_EQ(smoke.index_to_world[5], 0.5);
    EXPECT_TRUE(std::ranges::any_of(smoke.metadata, [](const VdbMetadata& meta) {
        return meta.name == "author" && meta.type == "string" && meta.value == "nobody";
    }));
    EXPECT_EQ(listing->grids[1].type, "vec3d");
    EXPECT_EQ(listing->grids[3].type, "int64");
}

TEST(VdbFile, ReadsTheLeavesAndTilesOfAGrid) {
    const TestFolder folder;
    write_text(folder / "smoke.vdb", file_of(example_grids()));
    const Result<VdbLeaves> smoke = read_vdb_leaves(folder / "smoke.vdb", "density");
    ASSERT_TRUE(smoke) << smoke.error().message();
    EXPECT_EQ(smoke->type, VdbLeaves::Type::floats);
    ASSERT_EQ(smoke->leaves.size(), 3u);
    std::map<std::array<std::int32_t, 3>, float> active;
    for_each_active(*smoke, [&](const auto& at, const float* value) { active[at] = *value; });
    EXPECT_EQ(active, (std::map<std::array<std::int32_t, 3>, float>{{{1, 2, 3}, 4}, {{-1, 0, 9}, 5}}));
    ASSERT_EQ(smoke->tiles.size(), 1u);
    EXPECT_EQ(smoke->tiles[0].origin, (std::array{16, 16, 16}));
    EXPECT_EQ(smoke->tiles[0].size, 8);
    EXPECT_EQ(smoke->tiles[0].active, 1);
    EXPECT_EQ(number(*smoke, 3 * VdbLeaves::leaf_voxels), 7.0f);
    for (std::size_t leaf = 0; leaf < 3; ++leaf)
        if (smoke->leaves[leaf].origin == std::array{96, 0, 0}) {
            EXPECT_EQ(number(*smoke, leaf * 512 + 4 * 64), 6.0f) << "an inactive voxel";
        }

    const Result<VdbLeaves> wind = read_vdb_leaves(folder / "smoke.vdb", "wind");
    ASSERT_TRUE(wind) << wind.error().message();
    EXPECT_EQ(wind->components, 3u);
    for_each_active(*wind, [](const auto&, const float* value) { EXPECT_EQ(value[2], 3.0f); });
    const Result<VdbLeaves> mask = read_vdb_leaves(folder / "smoke.vdb", "mask");
    ASSERT_TRUE(mask);
    EXPECT_EQ(mask->type, VdbLeaves::Type::ints);
    EXPECT_EQ(mask->values[5 * 64 + 5 * 8 + 5], 1u);
}

TEST(VdbFile, ErrorsNameFileAndGrid) {
    const TestFolder folder;
    const std::string bytes = file_of(example_grids());
    write_text(folder / "smoke.vdb", bytes);
    const auto missing = read_vdb_leaves(folder / "smoke.vdb", "temperature");
    ASSERT_FALSE(missing);
    EXPECT_EQ(missing.error().where, (folder / "smoke.vdb").string());
    EXPECT_NE(missing.error().what.find("\"temperature\""), std::string::npos);
    const auto large = read_vdb_leaves(folder / "smoke.vdb", "large");
    ASSERT_FALSE(large);
    EXPECT_NE(large.error().what.find("int64"), std::string::npos) << large.error().what;
    for (std::size_t size = 0; size < bytes.size(); size += 1 + bytes.size() / 60) {
        write_text(folder / "cut.vdb", std::string_view(bytes).substr(0, size));
        const Result<VdbListing> listing = read_vdb_listing(folder / "cut.vdb");
        const Result<VdbLeaves> leaves = read_vdb_leaves(folder / "cut.vdb", "mask");
        EXPECT_FALSE(leaves) << size;
        if (!listing) {
            EXPECT_FALSE(listing.error().what.empty());
        }
    }
}

}  // namespace
}  // namespace haarfield
