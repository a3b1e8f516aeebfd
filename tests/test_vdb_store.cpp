#include "fields/field/vdb_store.h"

#include <gtest/gtest.h>
#include <openvdb/io/File.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <xxhash.h>

#include <cstdio>
#include <sstream>

#include "fields/field/field_blob.h"
#include "fields/field/field_file.h"
#include "tests/fixtures/field_fixtures.h"
#include "tests/fixtures/test_folder.h"

namespace haarfield {
namespace {

using std::filesystem::path;

/// Reads the grids as another program does, without the type of haarfield's metadata.
openvdb::GridPtrVec grids_of(const VdbFile& file) {
    openvdb::initialize();
    std::istringstream stream(file.bytes);
    return *openvdb::io::Stream(stream, /*delayLoad=*/false).getGrids();
}

std::int64_t hash_of(const void* values, std::size_t bytes) {
    return static_cast<std::int64_t>(XXH3_64bits(values, bytes));
}

TEST(VdbStore, GridsHoldTheHandlesWhereTheHeaderSays) {
    // Vertices fill bricks of 2^9, rows of bricks of 2^13 and layers of 2^17.
    for (const std::size_t vertices : {0, 1, 511, 513, 9000, 140000}) {
        const VisibilityField field = random_field(static_cast<std::uint32_t>(vertices), vertices);
        const Result<VdbFile> file = vdb_file(field);
        ASSERT_TRUE(file) << file.error().message();
        const openvdb::GridPtrVec grids = grids_of(*file);
        ASSERT_EQ(grids.size(), 6u);
        const auto tree = [&](std::size_t g) {
            return openvdb::gridPtrCast<openvdb::Int32Grid>(grids[g])->tree();
        };
        const auto planar = tree(2), spherical = tree(3), local = tree(4);
        EXPECT_EQ(planar.activeVoxelCount(), field.planar_handles.size());
        EXPECT_EQ(spherical.activeVoxelCount(), field.spherical_handles.size());
        EXPECT_EQ(local.activeVoxelCount(), vertices);
        EXPECT_EQ(planar.background(), -1);

        std::size_t i = 0;
        for (int ring = 0; ring < field.planar.rings; ++ring)
            for (int angle = 0; angle < field.planar.angles; ++angle)
                ASSERT_EQ(planar.getValue({ring, angle, 0}), field.planar_handles[i++]);
        i = 0;
        for (int shell = 0; shell < field.spherical.shells; ++shell)
            for (int row = 0; row < field.spherical.polar; ++row)
                for (int azimuth = 0; azimuth < field.spherical.azimuths; ++azimuth)
                    ASSERT_EQ(spherical.getValue({shell, row, azimuth}), field.spherical_handles[i++]);
        for (std::size_t v = 0; v < vertices; ++v) {
            const auto bits = [v](int first, int count) {
                return static_cast<int>(v >> first & ((1u << count) - 1));
            };
            ASSERT_EQ(local.getValue({bits(9, 4) * 8 + bits(6, 3), bits(13, 4) * 8 + bits(3, 3),
                                      bits(17, 14) * 8 + bits(0, 3)}),
                      field.local_handles[v])
                << v;
        }
        for (const auto& [grid, handles] : {std::pair(grids[2], &field.planar_handles),
                                            {grids[3], &field.spherical_handles},
                                            {grids[4], &field.local_handles}})
            EXPECT_EQ(grid->metaValue<std::int64_t>("haarfield_xxh3"),
                      hash_of(handles->data(), handles->size() * 4));
    }
}

TEST(VdbStore, EveryGridHasItsVersionSchemaAndHash) {
    const VdbFile file = *vdb_file(example_field());
    const openvdb::GridPtrVec grids = grids_of(file);
    for (const auto& grid : grids) {
        EXPECT_EQ(grid->metaValue<std::int32_t>("haarfield_version"),
                  static_cast<std::int32_t>(field_blob_version));
        EXPECT_NE(grid->metaValue<std::string>("haarfield_schema"), "");
    }
    std::vector<float> active;
    const auto ambient = openvdb::gridPtrCast<openvdb::FloatGrid>(grids[0]);
    for (int x = 0; x < 50; ++x)
        for (int y = 0; y < 50; ++y)
            for (int z = 0; z < 50; ++z)
                if (ambient->tree().isValueOn({x, y, z}))
                    active.push_back(ambient->tree().getValue({x, y, z}));
    EXPECT_EQ(active.size(), ambient->activeVoxelCount());
    EXPECT_EQ(ambient->metaValue<std::int64_t>("haarfield_xxh3"), hash_of(active.data(), active.size() * 4));
    const auto direction = openvdb::gridPtrCast<openvdb::Vec3SGrid>(grids[1]);
    EXPECT_TRUE(direction->tree().hasSameTopology(ambient->tree())) << "where one is shown, so is the other";
    EXPECT_EQ(direction->transform(), ambient->transform());
    EXPECT_EQ(direction->getVectorType(), openvdb::VEC_CONTRAVARIANT_RELATIVE);
    EXPECT_EQ(grids[5]->metaValue<std::int64_t>("haarfield_xxh3"),
              hash_of(file.blob().data(), file.blob_bytes));
}

TEST(VdbStore, TheBlobCanBeReadInPlace) {
    for (const std::size_t vertices : {0, 1, 7, 700}) {
        const VisibilityField field = random_field(static_cast<std::uint32_t>(vertices), vertices);
        const VdbFile file = *vdb_file(field);
        EXPECT_EQ(file.blob_offset % field_blob_alignment, 0u);
        EXPECT_EQ(file.blob(), field_blob(field));
    }
}

TEST(VdbStore, AFieldSurvivesAnotherProgram) {
    const TestFolder folder;
    for (std::uint32_t seed = 1; seed < 6; ++seed) {
        const VisibilityField field = random_field(seed, 100);
        openvdb::GridPtrVec grids = grids_of(*vdb_file(field));
        for (const auto& grid : grids)
            grid->insertMeta("note", openvdb::StringMetadata(std::string(seed, 'x')));
        const path file = folder / "saved.vdb";
        openvdb::io::File(file.string()).write(grids);
        EXPECT_FALSE(read_field(file));
        const Result<VisibilityField> read = read_field(file, Unsealed::allowed);
        ASSERT_TRUE(read) << read.error().message();
        expect_same(*read, field, "saved again");
    }
}

/// Runs a command and returns what it writes, or nothing if it fails.
std::string output_of(const std::string& command) {
    std::string output;
    FILE* pipe = popen(command.c_str(), "r");
    if (!pipe) return {};
    char buffer[4096];
    while (const std::size_t count = std::fread(buffer, 1, sizeof buffer, pipe)) output.append(buffer, count);
    return pclose(pipe) == 0 ? output : std::string();
}

TEST(VdbStore, VdbPrintListsTheGridsWithoutAWarning) {
    if (output_of("command -v vdb_print").empty()) GTEST_SKIP() << "vdb_print is not installed";
    const TestFolder folder;
    ASSERT_TRUE(write_field(example_field(), folder / "example.vdb"));
    const path errors = folder / "errors";
    const std::string listing =
        output_of("vdb_print -l '" + (folder / "example.vdb").string() + "' 2>'" + errors.string() + "'");
    EXPECT_EQ(text_of(errors), "");
    for (const char* grid : {"ambient_visibility", "open_direction", "planar_handles", "spherical_handles",
                             "local_handles", "quadtree_pool"})
        EXPECT_NE(listing.find(grid), std::string::npos) << grid << " is missing in:\n" << listing;
    EXPECT_NE(listing.find("fog volume"), std::string::npos) << listing;
}

TEST(VdbStore, PyopenvdbReadsAmbientVisibilityByName) {
    const std::string python = "/usr/bin/python3";
    if (output_of(python + " -c 'import pyopenvdb; print(1)' 2>/dev/null").empty())
        GTEST_SKIP() << "pyopenvdb is not installed";
    const TestFolder folder;
    ASSERT_TRUE(write_field(example_field(), folder / "example.vdb"));
    const std::string script =
        "import pyopenvdb as vdb\n"
        "grid = vdb.read('" +
        (folder / "example.vdb").string() +
        "', 'ambient_visibility')\n"
        "voxels = [v.value for v in grid.citerOnValues()]\n"
        "print(grid.background, len(voxels) > 1000, 0 <= min(voxels) < max(voxels) < 1,\n"
        "      grid.getAccessor().getValue(tuple(int(c) for c in grid.transform.worldToIndex((-50, 9, "
        "2)))),\n"
        "      grid.getAccessor().getValue(tuple(round(c) for c in grid.transform.worldToIndex((0, 0.7, "
        "0)))))\n";
    write_text(folder / "read.py", script);
    EXPECT_EQ(output_of(python + " '" + (folder / "read.py").string() + "' 2>&1"), "1.0 True True 1.0 0.0\n");
}

}  // namespace
}  // namespace haarfield
