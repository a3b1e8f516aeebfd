#include "fields/field/field_grids.h"

#include <gtest/gtest.h>
#include <openvdb/tools/Prune.h>

#include <cstdio>

#include "fields/base/sanitizers.h"
#include "fields/field/field_file.h"
#include "fields/field/field_precompute.h"
#include "fields/field/field_transfer.h"
#include "fields/wavelets/haar_transform.h"
#include "tests/fixtures/example_meshes.h"
#include "tests/fixtures/field_fixtures.h"
#include "tests/fixtures/forged_grids.h"
#include "tests/fixtures/test_folder.h"

namespace haarfield {
namespace {

using openvdb::GridPtrVec;
using openvdb::Int32Grid;
using std::filesystem::path;

/// Adds an unoccluded cubemap, in the middle of the others, for every third sample.
VisibilityField partly_open(VisibilityField field) {
    QuadtreePoolBuilder pool(field.pool.face_size);
    const auto count = static_cast<std::int32_t>(field.pool.cubemaps.size());
    PackedTrees packed;
    for (std::int32_t handle = 0; handle < count; ++handle) {
        take_trees(field.pool, handle, packed);
        pool.add(packed);
        if (handle != count / 2) continue;
        CubemapTree open;
        for (Quadtree& face : open.faces) face.scaling = 1;
        pack_trees(open, packed);
        pool.add(packed);
    }
    field.pool = std::move(pool).finish();
    const std::int32_t open = unoccluded_cubemap(field.pool);
    for (auto* handles : {&field.planar_handles, &field.spherical_handles, &field.local_handles})
        for (std::size_t i = 0; i < handles->size(); i += 3) (*handles)[i] = open;
    return field;
}

VisibilityField partly_open_field() {
    return partly_open(random_field(3, 700));
}

Result<VisibilityField> read_bytes(const TestFolder& folder, const std::string& bytes) {
    write_text(folder / "changed.vdb", bytes);
    return read_field(folder / "changed.vdb");
}

/// The values of a table's grid, -1 where a voxel is inactive.
std::vector<std::int32_t> values_of(const GridPtrVec& grids, const std::string& name) {
    const auto grid = openvdb::gridPtrCast<Int32Grid>(grid_named(grids, name));
    std::vector<std::int32_t> values(std::size_t(grid->metaValue<openvdb::Int64>("haarfield_count")), -1);
    for (std::size_t i = 0; i < values.size(); ++i) {
        std::int32_t value = 0;
        if (grid->tree().probeValue(voxel_of(*grid, i), value)) values[i] = value;
    }
    return values;
}

template <class T>
std::string bytes_of(const T& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(values[0])};
}

TEST(FieldGrids, HoldTheTablesWhereTheFormatSays) {
    for (const std::size_t vertices : {0, 1, 511, 513, 9000, 140000}) {
        const VisibilityField field = random_field(static_cast<std::uint32_t>(vertices), vertices);
        const Result<std::string> file = field_file_bytes(field);
        ASSERT_TRUE(file) << file.error().message();
        const GridPtrVec grids = grids_of(*file);
        ASSERT_EQ(grids.size(), 8u);
        EXPECT_EQ(values_of(grids, "planar_handles"), field.planar_handles);
        EXPECT_EQ(values_of(grids, "spherical_handles"), field.spherical_handles);
        EXPECT_EQ(values_of(grids, "local_handles"), field.local_handles);
        EXPECT_EQ(bytes_of(values_of(grids, "cubemaps")), bytes_of(field.pool.cubemaps));
        EXPECT_EQ(bytes_of(values_of(grids, "faces")), bytes_of(field.pool.faces));
        EXPECT_EQ(bytes_of(values_of(grids, "nodes_0")).substr(0, field.pool.node_bytes.size()),
                  bytes_of(field.pool.node_bytes));
        EXPECT_EQ(openvdb::gridPtrCast<Int32Grid>(grid_named(grids, "local_handles"))->background(), -1);
    }
}

TEST(FieldGrids, UnoccludedSamplesAreInactive) {
    const VisibilityField field = partly_open_field();
    const std::int32_t open = unoccluded_cubemap(field.pool);
    const GridPtrVec grids = grids_of(*field_file_bytes(field));
    for (const auto& [name, handles] : {std::pair("planar_handles", &field.planar_handles),
                                        std::pair("spherical_handles", &field.spherical_handles),
                                        std::pair("local_handles", &field.local_handles)}) {
        const auto grid = grid_named(grids, name);
        const auto occluded = handles->size() - std::size_t(std::ranges::count(*handles, open));
        EXPECT_EQ(grid->activeVoxelCount(), occluded) << name;
        EXPECT_LT(occluded, handles->size());
        EXPECT_EQ(values_of(grids, name)[3], -1);
    }
    const TestFolder folder;
    const Result<VisibilityField> read = read_bytes(folder, *field_file_bytes(field));
    ASSERT_TRUE(read) << read.error().message();
    expect_same(*read, field, "partly open");
}

TEST(FieldGrids, HashesAreThoseOfTheFormat) {
    const GridPtrVec grids = grids_of(*field_file_bytes(example_field()));
    std::map<std::string, std::pair<std::string, std::string>> written;
    for (const auto& grid : grids) {
        EXPECT_EQ(grid->metaValue<std::string>("haarfield_hash"), expected_hash(*grid)) << grid->getName();
        written[grid->getName()] = {grid->metaValue<std::string>("haarfield_hash"),
                                    grid->metaValue<std::string>("haarfield_field")};
    }
    rehash(grids);
    for (const auto& grid : grids) {
        EXPECT_EQ(grid->metaValue<std::string>("haarfield_field"), written[grid->getName()].second);
        EXPECT_EQ(grid->metaValue<std::int32_t>("haarfield_version"), field_format_version);
        EXPECT_NE(grid->metaValue<std::string>("haarfield_schema"), "");
    }
}

TEST(FieldGrids, FilesSavedAgainRemainValid) {
    const TestFolder folder;
    const VisibilityField field = partly_open_field();
    for (const std::uint32_t compression :
         {openvdb::io::COMPRESS_NONE, openvdb::io::COMPRESS_ZIP, openvdb::io::COMPRESS_BLOSC}) {
        GridPtrVec grids = grids_of(*field_file_bytes(field));
        std::reverse(grids.begin(), grids.end());
        for (const auto& grid : grids)
            grid->insertMeta("note", openvdb::StringMetadata("by another program"));
        Result<VisibilityField> read = read_bytes(folder, file_of(grids, compression));
        ASSERT_TRUE(read) << read.error().message();
        expect_same(*read, field, "compression " + std::to_string(compression));
        openvdb::io::File(folder / "file.vdb").write(grids);
        read = read_field(folder / "file.vdb");
        ASSERT_TRUE(read) << read.error().message();
        EXPECT_TRUE(verify_field(folder / "file.vdb"));
    }
}

TEST(FieldGrids, EqualVoxelsMayBeMergedToTiles) {
    const TestFolder folder;
    VisibilityField field = random_field(4, 9000);
    std::fill(field.local_handles.begin(), field.local_handles.begin() + 5000, 7);
    const GridPtrVec grids = grids_of(*field_file_bytes(field));
    const auto local = openvdb::gridPtrCast<Int32Grid>(grid_named(grids, "local_handles"));
    const auto leaves = local->tree().leafCount();
    openvdb::tools::prune(local->tree());
    EXPECT_LT(local->tree().leafCount(), leaves);
    const Result<VisibilityField> read = read_bytes(folder, file_of(grids));
    ASSERT_TRUE(read) << read.error().message();
    expect_same(*read, field, "pruned");
}

/// Expects that a changed file is refused, and that the error names the grid.
void expect_refused(const TestFolder& folder, const GridPtrVec& grids, const std::string& grid,
                    const std::string& which) {
    const Result<VisibilityField> read = read_bytes(folder, file_of(grids));
    ASSERT_FALSE(read) << which;
    EXPECT_NE(read.error().what.find('"' + grid + '"'), std::string::npos)
        << which << ": " << read.error().what;
    EXPECT_EQ(read.error().where, (folder / "changed.vdb").string());
}

TEST(FieldGrids, ChangedGridsAreRefusedByName) {
    const TestFolder folder;
    const std::string file = *field_file_bytes(example_field()),
                      other = *field_file_bytes(random_field(1, 10));
    for (const std::string name : {"planar_handles", "spherical_handles", "local_handles", "cubemaps",
                                   "faces", "nodes_0", "ambient_visibility", "open_direction"}) {
        const auto changed = [&](const std::string& which, const auto& change) {
            GridPtrVec grids = grids_of(file);
            change(grids, grid_named(grids, name));
            expect_refused(folder, grids, name, name + ": " + which);
        };
        changed("missing",
                [](GridPtrVec& grids, const openvdb::GridBase::Ptr& grid) { std::erase(grids, grid); });
        changed("changed metadata", [](GridPtrVec&, const openvdb::GridBase::Ptr& grid) {
            grid->insertMeta("haarfield_schema", openvdb::StringMetadata("another"));
        });
        changed("more metadata", [](GridPtrVec&, const openvdb::GridBase::Ptr& grid) {
            grid->insertMeta("haarfield_added", openvdb::Int32Metadata(1));
        });
        changed("without its hash",
                [](GridPtrVec&, const openvdb::GridBase::Ptr& grid) { grid->removeMeta("haarfield_hash"); });
        changed("twice", [](GridPtrVec& grids, const openvdb::GridBase::Ptr& grid) {
            grids.push_back(grid->deepCopyGrid());
        });
        changed("cropped", [](GridPtrVec&, const openvdb::GridBase::Ptr& grid) {
            const openvdb::CoordBBox box = grid->evalActiveVoxelBoundingBox();
            if (grid->isType<Int32Grid>())
                static_cast<Int32Grid&>(*grid).beginValueOn().setValueOff();
            else if (grid->isType<openvdb::FloatGrid>())
                static_cast<openvdb::FloatGrid&>(*grid).clip({box.min(), box.max().offsetBy(-1)});
            else
                static_cast<openvdb::Vec3SGrid&>(*grid).clip({box.min(), box.max().offsetBy(-1)});
        });
        changed("changed value", [](GridPtrVec&, const openvdb::GridBase::Ptr& grid) {
            if (grid->isType<Int32Grid>()) {
                auto voxel = static_cast<Int32Grid&>(*grid).beginValueOn();
                voxel.setValue(voxel.getValue() ^ 1);
            } else if (grid->isType<openvdb::FloatGrid>()) {
                auto voxel = static_cast<openvdb::FloatGrid&>(*grid).beginValueOn();
                voxel.setValue(voxel.getValue() + 1e-6f);
            } else {
                auto voxel = static_cast<openvdb::Vec3SGrid&>(*grid).beginValueOn();
                voxel.setValue(voxel.getValue() + openvdb::Vec3s(1e-6f));
            }
        });
    }
    for (const auto& grid : grids_of(file))
        expect_refused(folder, {grid}, grid->getName() == "cubemaps" ? "faces" : "cubemaps",
                       grid->getName() + " alone");
    GridPtrVec grids = grids_of(file);
    grids.push_back(Int32Grid::create());
    grids.back()->setName("surplus");
    expect_refused(folder, grids, "surplus", "an extra grid");
    grids = grids_of(file);
    for (auto& grid : grids)
        if (grid->getName() == "local_handles") grid = grid_named(grids_of(other), "local_handles");
    const Result<VisibilityField> mixed = read_bytes(folder, file_of(grids));
    ASSERT_FALSE(mixed);
    EXPECT_NE(mixed.error().what.find("grids of several fields"), std::string::npos) << mixed.error().what;
    EXPECT_FALSE(read_bytes(folder, file + "x")) << "bytes after the last grid";
}

TEST(FieldGrids, OptionalGridsAreIgnored) {
    const TestFolder folder;
    GridPtrVec grids = grids_of(*field_file_bytes(example_field()));
    grids.push_back(Int32Grid::create());
    grids.back()->setName("derived_meshes");
    const Result<VisibilityField> read = read_bytes(folder, file_of(grids));
    ASSERT_TRUE(read) << read.error().message();
    expect_same(*read, example_field(), "with an optional grid");
}

TEST(FieldGrids, EarlierVersionsAndOtherFilesAreNamed) {
    const TestFolder folder;
    const auto error = [&](const GridPtrVec& grids) {
        return read_bytes(folder, file_of(grids)).error().what;
    };
    GridPtrVec grids{Int32Grid::create(-1)};
    grids[0]->setName("quadtree_pool");
    grids[0]->insertMeta("haarfield_version", openvdb::Int32Metadata(6));
    EXPECT_NE(error(grids).find("is a field of version 6; expected version 7"), std::string::npos)
        << error(grids);
    grids[0]->setName("density");
    EXPECT_NE(error(grids).find("not a visibility field"), std::string::npos) << error(grids);
    grids = grids_of(*field_file_bytes(example_field()));
    grid_named(grids, "cubemaps")->insertMeta("haarfield_version", openvdb::Int32Metadata(8));
    EXPECT_NE(error(grids).find("is a field of version 8"), std::string::npos) << error(grids);
}

/// Files whose hashes are correct.
TEST(FieldGrids, ForgedFieldsAreRefused) {
    if (is_thread_sanitized) GTEST_SKIP() << "forged counts fill the memory";
    const TestFolder folder;
    const VisibilityField field = random_field(7, 100);
    const std::string file = *field_file_bytes(field);
    {
        GridPtrVec grids = grids_of(file);
        rehash(grids);
        ASSERT_TRUE(read_bytes(folder, file_of(grids))) << "not forged at all";
    }
    const auto refused = [&](const std::string& which, const auto& forge) {
        GridPtrVec grids = grids_of(file);
        forge(grids);
        rehash(grids);
        const Result<VisibilityField> read = read_bytes(folder, file_of(grids));
        EXPECT_FALSE(read) << which;
        if (!read) {
            EXPECT_EQ(read.error().what.find("hash"), std::string::npos) << which << read.error().what;
        }
    };
    const auto refused_value = [&](const std::string& grid, std::uint64_t i, std::int32_t value) {
        refused(grid + " value " + std::to_string(i), [&](GridPtrVec& grids) {
            auto& table = static_cast<Int32Grid&>(*grid_named(grids, grid));
            table.tree().setValueOn(voxel_of(table, i), value);
        });
    };
    const auto refused_meta = [&](const std::string& grid, const std::string& name, auto value) {
        refused(grid + " " + name, [&](GridPtrVec& grids) {
            const auto changed = grid_named(grids, grid);
            changed->removeMeta("haarfield_" + name);  // its type may change, too
            changed->insertMeta("haarfield_" + name, openvdb::TypedMetadata<decltype(value)>(value));
        });
    };
    refused_value("planar_handles", 1, 50);
    refused_value("spherical_handles", 2, -2);
    refused_value("spherical_handles", 2, -1);
    refused_value("local_handles", 99, 0x7fffffff);
    refused_value("cubemaps", 2, 1 << 20);
    refused_value("faces", 0, -1);      // nodes beyond the last
    refused_value("faces", 1, 1);       // beyond 4 GiB
    refused_value("nodes_0", 0, 0x70);  // nodes that nothing leads to
    refused_value("nodes_0", 0, 0xff);  // a node of no kind
    for (const std::int32_t size : {0, 2, 48, 512}) refused_meta("cubemaps", "face_size", size);
    refused_meta("cubemaps", "lower", openvdb::Vec3s(NAN, 0, 0));
    refused_meta("cubemaps", "key", std::string("0"));
    refused_meta("cubemaps", "node_bytes", openvdb::Int64(-1));
    refused_meta("cubemaps", "node_bytes", openvdb::Int64(1) << 60);
    refused_meta("cubemaps", "node_bytes", openvdb::Int64(5));
    refused_meta("faces", "count", openvdb::Int64(1) << 40);
    refused_meta("cubemaps", "count", openvdb::Int64(299));
    for (const std::int32_t rings : {0x7fffffff, -1, 0, field.planar.rings - 1, field.planar.rings + 1})
        refused_meta("planar_handles", "rings", rings);
    refused_meta("planar_handles", "angles", std::int32_t(0));
    refused_meta("planar_handles", "outer_radius", float(INFINITY));
    refused_meta("planar_handles", "error_bands", std::string("0 0 x"));
    refused_meta("planar_handles", "error", std::string("0"));
    refused_meta("spherical_handles", "shells", std::int32_t(1) << 20);
    refused_meta("spherical_handles", "azimuths", std::int32_t(-3));
    refused_meta("local_handles", "count", openvdb::Int64(99));
    refused_meta("local_handles", "count", openvdb::Int64(0x7fffffff));
    refused("a voxel outside a table", [](GridPtrVec& grids) {
        static_cast<Int32Grid&>(*grid_named(grids, "local_handles")).tree().setValueOn({9, 9, 9}, 1);
    });
    refused("a tile of 4096^3 voxels", [](GridPtrVec& grids) {
        static_cast<Int32Grid&>(*grid_named(grids, "nodes_0")).tree().addTile(3, {4096, 0, 0}, 1, true);
    });
    refused("another type of values", [](GridPtrVec& grids) {
        for (auto& grid : grids)
            if (grid->getName() == "faces") {
                const auto floats = openvdb::FloatGrid::create();
                for (auto meta = grid->beginMeta(); meta != grid->endMeta(); ++meta)
                    floats->insertMeta(meta->first, *meta->second);
                grid = floats;
            }
    });
}

TEST(FieldGrids, TheHeadNeedsNoTables) {
    const VisibilityField field = random_field(5, 100);
    const std::string file = *field_file_bytes(field);
    std::string bytes;
    ByteSink sink([&](std::string_view piece) { bytes += piece; });
    ASSERT_TRUE(read_field_grids(file, FieldContent::head, sink));
    const Result<FieldHead> head = transferred_head(bytes);
    ASSERT_TRUE(head);
    EXPECT_EQ(head->field.entity, field.entity);
    EXPECT_EQ(head->counts.local, 100u);
    EXPECT_EQ(head->counts.node_bytes, field.pool.node_bytes.size());
    EXPECT_LT(bytes.size(), 1000u);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
        const auto owner = std::make_shared<std::string>(bytes.substr(0, size));
        EXPECT_FALSE(transferred_field({*owner, owner})) << size;
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

/// The picture that print_visibility writes for a cubemap.
std::string faces_text(const QuadtreePool& pool, std::int32_t handle) {
    const int size = pool.face_size;
    std::string text = "P2\n# faces +x -x +y -y +z -z, from top to bottom\n" + std::to_string(size) + " " +
                       std::to_string(6 * size) + "\n255\n";
    Quadtree tree;
    for (const std::uint32_t face : pool.cubemaps[std::size_t(handle)]) {
        unpack_face(pool, face, tree);
        for (const float texel : quadtree_texels(tree, size))
            text += std::to_string(std::lround(255 * std::clamp(texel, 0.0f, 1.0f))) + "\n";
    }
    return text;
}

TEST(FieldGrids, AProgramThatKnowsOnlyOpenVdbReadsThem) {
    const TestFolder folder;
    for (const VisibilityField& field : {example_field(), partly_open(example_field())}) {
        ASSERT_TRUE(write_field(field, folder / "field.vdb"));
        for (std::uint32_t sample = 0; sample < field.planar.sample_count(); sample += 13) {
            const Vec3f at = field.planar.sample_position(sample);
            const std::string command = std::string(HAARFIELD_PRINT_VISIBILITY) + " '" +
                                        (folder / "field.vdb").string() + "' " + std::to_string(at.x) + " " +
                                        std::to_string(at.z);
            // At the centre, all angles of the first ring are equally near.
            const std::uint32_t nearest = sample < std::uint32_t(field.planar.angles) ? 0 : sample;
            if (nearest != sample) continue;
            EXPECT_EQ(output_of(command), faces_text(field.pool, field.planar_handles[sample])) << sample;
        }
    }
}

TEST(FieldGrids, VdbPrintListsThemWithoutAWarning) {
    if (output_of("command -v vdb_print").empty()) GTEST_SKIP() << "vdb_print is not installed";
    const TestFolder folder;
    ASSERT_TRUE(write_field(example_field(), folder / "example.vdb"));
    const path errors = folder / "errors";
    const std::string listing =
        output_of("vdb_print -l '" + (folder / "example.vdb").string() + "' 2>'" + errors.string() + "'");
    EXPECT_EQ(text_of(errors), "");
    for (const char* grid : {"ambient_visibility", "open_direction", "planar_handles", "spherical_handles",
                             "local_handles", "cubemaps", "faces", "nodes_0"})
        EXPECT_NE(listing.find(grid), std::string::npos) << grid << " is missing in:\n" << listing;
    EXPECT_NE(listing.find("fog volume"), std::string::npos) << listing;
}

TEST(FieldGrids, PyopenvdbReadsAmbientVisibilityByName) {
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
