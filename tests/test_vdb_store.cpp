#include "fields/vdb_store.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>
#include <xxhash.h>

#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <random>
#include <thread>

#include "fields/ambient_visibility.h"
#include "fields/field_blob.h"
#include "fields/field_precompute.h"
#include "fields/haar_transform.h"
#include "tests/example_meshes.h"

namespace haarfield {
namespace {

using std::filesystem::path;

/// A folder of one test's own, gone after it.
class Folder {
public:
    Folder() {
        const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
        path_ = path(::testing::TempDir()) /
                ("haarfield_" + std::string(test->name()) + "_" + std::to_string(getpid()));
        std::filesystem::create_directories(path_);
    }
    ~Folder() { std::filesystem::remove_all(path_); }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;

    path file(const char* name = "example.vdb") const { return path_ / name; }
    std::size_t entries() const {
        return static_cast<std::size_t>(
            std::distance(std::filesystem::directory_iterator(path_), std::filesystem::directory_iterator()));
    }

private:
    path path_;
};

std::string file_bytes(const path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

void write_bytes(const path& file, std::string_view bytes) {
    std::ofstream(file, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

const VisibilityField& example_field() {
    static const VisibilityField field = [] {
        const PreparedMesh mesh = prepared_as_is(joined_meshes(
            box_mesh({-0.5f, 0, -0.5f}, {0.5f, 1, 0.5f}, 3), sphere_mesh({0, 1.2f, 0}, 0.4f, 8)));
        return *precompute_field("a chair: \xc3\xa9", mesh, EntityOcclusion(mesh), {16, 10, 0, 100, 150});
    }();
    return field;
}

/// Without geometry behind it: tables of any length.
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
    field.error = {0.25f, 0.0f};
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

template <class T>
bool same_bits(const T& a, const T& b) {
    return std::memcmp(&a, &b, sizeof a) == 0;
}

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

void expect_round_trip(const VisibilityField& field, const std::string& which) {
    const Folder folder;
    const Result<Done> written = write_field(field, folder.file());
    ASSERT_TRUE(written) << which << ": " << written.error().message();
    const Result<VisibilityField> read = read_field(folder.file());
    ASSERT_TRUE(read) << which << ": " << read.error().message();
    expect_same(*read, field, which);
}

TEST(VdbStore, FieldsRoundTripBitForBit) {
    expect_round_trip(example_field(), "example");
    // Vertices fill bricks of 2^9, rows of bricks of 2^13 and layers of 2^17.
    std::uint32_t seed = 0;
    for (const std::size_t vertices : {0, 1, 511, 513, 9000, 140000})
        expect_round_trip(random_field(++seed, vertices), std::to_string(vertices) + " vertices");
}

TEST(VdbStore, EqualFieldsMakeEqualFiles) {
    const Folder folder;
    ASSERT_TRUE(write_field(example_field(), folder.file("a.vdb")));
    ASSERT_TRUE(write_field(example_field(), folder.file("b.vdb")));
    EXPECT_EQ(file_bytes(folder.file("a.vdb")), file_bytes(folder.file("b.vdb")));
    ASSERT_TRUE(write_field(random_field(1, 10), folder.file("b.vdb")));
    EXPECT_NE(file_bytes(folder.file("a.vdb")).substr(21, 36),
              file_bytes(folder.file("b.vdb")).substr(21, 36));
}

TEST(VdbStore, KeyIsReadFromTheSeal) {
    const Folder folder;
    ASSERT_TRUE(write_field(example_field(), folder.file()));
    const Result<ContentHash> key = read_field_key(folder.file());
    ASSERT_TRUE(key) << key.error().message();
    EXPECT_EQ(*key, example_field().key);
    write_bytes(folder.file(), file_bytes(folder.file()) + "x");
    EXPECT_FALSE(read_field_key(folder.file()));
    EXPECT_FALSE(read_field_key(folder.file("missing.vdb")));
}

TEST(VdbStore, SummaryCountsWhatIsInTheFile) {
    const Folder folder;
    const VisibilityField field = random_field(5, 700);
    ASSERT_TRUE(write_field(field, folder.file()));
    const Result<FieldSummary> summary = read_field_summary(folder.file());
    ASSERT_TRUE(summary) << summary.error().message();
    EXPECT_EQ(summary->entity, field.entity);
    EXPECT_EQ(summary->key, field.key);
    EXPECT_EQ(summary->settings, field.settings);
    EXPECT_EQ(summary->planar.rings, field.planar.rings);
    EXPECT_EQ(summary->spherical.azimuths, field.spherical.azimuths);
    EXPECT_EQ(summary->local_samples, 700u);
    EXPECT_EQ(summary->nodes, node_count(field.pool));
    EXPECT_EQ(summary->faces, field.pool.faces.size());
    EXPECT_EQ(summary->cubemaps, 50u);
    EXPECT_EQ(summary->file_bytes, std::filesystem::file_size(folder.file()));
    EXPECT_TRUE(verify_field(folder.file()));
}

/// By everything that reads a whole file.
void expect_refused(const path& file, const std::string& which) {
    const Result<VisibilityField> field = read_field(file);
    ASSERT_FALSE(field) << which;
    EXPECT_EQ(field.error().where, file.string());
    EXPECT_FALSE(field.error().what.empty());
    EXPECT_FALSE(verify_field(file)) << which;
}

TEST(VdbStore, RefusesAFileCutShortAnywhere) {
    const Folder folder;
    ASSERT_TRUE(write_field(example_field(), folder.file()));
    const std::string bytes = file_bytes(folder.file());
    const std::size_t step = bytes.size() / 300;
    for (std::size_t size = 0; size < bytes.size();
         size += bytes.size() - size <= 130 || size < 130 ? 1 : step) {
        write_bytes(folder.file("cut.vdb"), std::string_view(bytes).substr(0, size));
        expect_refused(folder.file("cut.vdb"), std::to_string(size) + " bytes");
        EXPECT_FALSE(read_field_key(folder.file("cut.vdb"))) << size;
    }
}

TEST(VdbStore, RefusesAFileWithAChangedByte) {
    const Folder folder;
    ASSERT_TRUE(write_field(example_field(), folder.file()));
    const std::string bytes = file_bytes(folder.file());
    std::mt19937 random(2006);
    for (int i = 0; i < 500; ++i) {
        // A seventh of them in the seal.
        const std::size_t place =
            i % 7 == 0 ? bytes.size() - 1 - random() % field_seal_size : random() % bytes.size();
        std::string changed = bytes;
        changed[place] = static_cast<char>(changed[place] ^ (1 << random() % 8));
        write_bytes(folder.file("changed.vdb"), changed);
        expect_refused(folder.file("changed.vdb"), "byte " + std::to_string(place));
    }
}

TEST(VdbStore, RefusesWhatIsNoField) {
    const Folder folder;
    expect_refused(folder.file("missing.vdb"), "missing file");
    expect_refused(folder.file().parent_path(), "folder");
    expect_refused("/dev/null", "device");
    write_bytes(folder.file(), "");
    expect_refused(folder.file(), "empty file");
    write_bytes(folder.file(), std::string(1000, 'x'));
    expect_refused(folder.file(), "text");
    // Sealed, but with nothing that OpenVDB could read.
    const std::string text(1000, 'x');
    write_bytes(folder.file(), text + field_seal(text, {}));
    expect_refused(folder.file(), "sealed text");
    write_bytes(folder.file(), field_seal("", {}));
    expect_refused(folder.file(), "lone seal");
}

TEST(VdbStore, RefusesAFileThatAnotherProgramSaved) {
    const Folder folder;
    ASSERT_TRUE(write_field(example_field(), folder.file()));
    std::string bytes = file_bytes(folder.file());
    bytes.resize(bytes.size() - field_seal_size);
    write_bytes(folder.file(), bytes);
    const Result<VisibilityField> field = read_field(folder.file());
    ASSERT_FALSE(field);
    EXPECT_NE(field.error().what.find("saved by another program"), std::string::npos) << field.error().what;
}

/// A field file taken apart, so that its tables can be forged with every checksum right.
struct ForgedFile {
    std::string before, blob, after;
    ContentHash key;

    explicit ForgedFile(const VisibilityField& field, const path& file) : key(field.key) {
        EXPECT_TRUE(write_field(field, file));
        const std::string bytes = file_bytes(file);
        const std::size_t begin = bytes.find("HAARBLOB"), size = field_blob(field).size();
        before = bytes.substr(0, begin);
        blob = bytes.substr(begin, size);
        after = bytes.substr(begin + size);
        after.resize(after.size() - field_seal_size);
    }

    /// Offset of the first byte of the section at an index of the list.
    std::uint64_t section(std::size_t index) const { return word(24 + 32 * index + 8); }

    std::uint64_t word(std::size_t offset) const {
        std::uint64_t value;
        std::memcpy(&value, blob.data() + offset, sizeof value);
        return value;
    }

    void write(const path& file, std::string forged_blob) const {
        const auto set_hash = [&](std::size_t at, std::size_t from, std::uint64_t size) {
            if (from > forged_blob.size() || size > forged_blob.size() - from) return;
            const std::uint64_t hash = XXH3_64bits(forged_blob.data() + from, size);
            std::memcpy(forged_blob.data() + at, &hash, sizeof hash);
        };
        for (std::size_t s = 0; s < 5; ++s) {
            std::uint64_t offset, size;
            std::memcpy(&offset, forged_blob.data() + 24 + 32 * s + 8, sizeof offset);
            std::memcpy(&size, forged_blob.data() + 24 + 32 * s + 16, sizeof size);
            set_hash(24 + 32 * s + 24, offset, size);
        }
        set_hash(24 + 32 * 5, 0, 24 + 32 * 5);
        const std::string bytes = before + forged_blob + after;
        write_bytes(file, bytes + field_seal(bytes, key));
    }
};

template <class T>
std::string with_value(std::string bytes, std::size_t offset, T value) {
    std::memcpy(bytes.data() + offset, &value, sizeof value);
    return bytes;
}

TEST(VdbStore, RefusesForgedTables) {
    const Folder folder;
    const VisibilityField field = random_field(7, 100);
    const ForgedFile whole(field, folder.file());
    whole.write(folder.file(), whole.blob);
    ASSERT_TRUE(read_field(folder.file())) << "not forged at all";

    enum Table : std::size_t { entity, record, cubemaps, faces, nodes };
    const auto at = [&](Table table, std::size_t offset = 0) { return whole.section(table) + offset; };
    const std::size_t list = 24;
    const std::pair<const char*, std::string> forgeries[] = {
        {"another version", with_value<std::uint32_t>(whole.blob, 8, 1)},
        {"more sections", with_value<std::uint32_t>(whole.blob, 12, 6)},
        {"a longer blob", with_value<std::uint64_t>(whole.blob, 16, ~0ull)},
        {"a section elsewhere", with_value<std::uint64_t>(whole.blob, list + 32 * 4 + 8, 1ull << 60)},
        {"a section of 2^64 bytes", with_value<std::uint64_t>(whole.blob, list + 32 * 4 + 16, ~0ull)},
        {"a section of 2^63 bytes", with_value<std::uint64_t>(whole.blob, list + 32 * 2 + 16, 1ull << 63)},
        {"face size 0", with_value<std::int32_t>(whole.blob, at(record), 0)},
        {"face size 2", with_value<std::int32_t>(whole.blob, at(record), 2)},
        {"face size 48", with_value<std::int32_t>(whole.blob, at(record), 48)},
        {"bounds not a number", with_value<float>(whole.blob, at(record, 20), NAN)},
        {"2^31 - 1 rings", with_value<std::int32_t>(whole.blob, at(record, 56), 0x7fffffff)},
        {"-1 rings", with_value<std::int32_t>(whole.blob, at(record, 56), -1)},
        {"0 rings", with_value<std::int32_t>(whole.blob, at(record, 56), 0)},
        {"one ring less", with_value<std::int32_t>(whole.blob, at(record, 56), field.planar.rings - 1)},
        {"one ring more", with_value<std::int32_t>(whole.blob, at(record, 56), field.planar.rings + 1)},
        {"0 angles", with_value<std::int32_t>(whole.blob, at(record, 60), 0)},
        {"infinite outer radius", with_value<float>(whole.blob, at(record, 64), INFINITY)},
        {"2^20 shells", with_value<std::int32_t>(whole.blob, at(record, 84), 1 << 20)},
        {"-3 azimuths", with_value<std::int32_t>(whole.blob, at(record, 92), -3)},
        {"a face beyond the last", with_value<std::uint32_t>(whole.blob, at(cubemaps, 8), 1u << 20)},
        {"a face with nodes beyond the last", with_value<std::uint32_t>(whole.blob, at(faces), ~0u)},
        {"nodes that nothing leads to", with_value<std::uint8_t>(whole.blob, at(nodes), 0x70)},
        {"a child beyond the last", with_value<std::uint8_t>(whole.blob, at(nodes, 4), 0x71)},
        {"a node of no kind", with_value<std::uint8_t>(whole.blob, at(nodes), 0xff)},
    };
    // The last face loses a byte to the nodes, and so on: tables that end within an element.
    for (const std::size_t s : {cubemaps, faces}) {
        const std::size_t here = list + 32 * s, next = here + 32;
        std::string blob = with_value(whole.blob, here + 16, whole.word(here + 16) - 1);
        blob = with_value(blob, next + 8, whole.word(next + 8) - 1);
        whole.write(folder.file(), with_value(blob, next + 16, whole.word(next + 16) + 1));
        expect_refused(folder.file(), "table " + std::to_string(s) + " a byte short");
    }
    for (const auto& [which, blob] : forgeries) {
        ASSERT_NE(blob, whole.blob) << which;
        whole.write(folder.file(), blob);
        expect_refused(folder.file(), which);
    }
}

TEST(VdbStore, ForgedTablesAreRefusedOrHarmless) {
    const Folder folder;
    const ForgedFile whole(random_field(11, 100), folder.file());
    std::mt19937 random(7);
    int refused = 0;
    for (int i = 0; i < 500; ++i) {
        std::string blob = whole.blob;
        for (std::uint32_t changes = 1 + random() % 3; changes > 0; --changes)
            blob[random() % blob.size()] = static_cast<char>(random());
        whole.write(folder.file(), blob);
        const Result<VisibilityField> field = read_field(folder.file());
        if (field)
            EXPECT_EQ(field_defect(*field), "");
        else
            ++refused;
    }
    EXPECT_GT(refused, 100);
    EXPECT_LT(refused, 500);
}

/// No file may grow beyond some bytes, as on a full disk, while this lives.
class SizeLimit {
public:
    explicit SizeLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
        getrlimit(RLIMIT_FSIZE, &before_);
        const rlimit limit{bytes, before_.rlim_max};
        setrlimit(RLIMIT_FSIZE, &limit);
    }
    ~SizeLimit() {
        setrlimit(RLIMIT_FSIZE, &before_);
        std::signal(SIGXFSZ, handler_);
    }
    SizeLimit(const SizeLimit&) = delete;
    SizeLimit& operator=(const SizeLimit&) = delete;

private:
    rlimit before_{};
    void (*handler_)(int);
};

TEST(VdbStore, AFullDiskLeavesTheFolderAsItWas) {
    const Folder folder;
    ASSERT_TRUE(write_field(example_field(), folder.file()));
    const std::string before = file_bytes(folder.file());
    VisibilityField other = example_field();
    other.entity = "other";
    for (const double part : {0.0, 0.1, 0.5, 0.9, 0.9999}) {
        const auto bytes = static_cast<rlim_t>(part * double(before.size()));
        const Result<Done> written = [&] {
            const SizeLimit limit(bytes);
            return write_field(other, folder.file());
        }();
        ASSERT_FALSE(written) << bytes << " bytes";
        EXPECT_EQ(written.error().where, folder.file().string());
        EXPECT_EQ(file_bytes(folder.file()), before);
        EXPECT_EQ(folder.entries(), 1u);
    }
    ASSERT_TRUE(write_field(other, folder.file()));
    EXPECT_EQ(read_field(folder.file())->entity, "other");
    EXPECT_EQ(folder.entries(), 1u);
}

TEST(VdbStore, RefusesToWriteADefectOrIntoNoFolder) {
    const Folder folder;
    EXPECT_FALSE(write_field(example_field(), folder.file("missing") / "example.vdb"));
    std::filesystem::create_directory(folder.file("folder"));
    EXPECT_FALSE(write_field(example_field(), folder.file("folder")));
    VisibilityField field = example_field();
    field.local_handles[0] = static_cast<std::int32_t>(field.pool.cubemaps.size());
    EXPECT_FALSE(write_field(field, folder.file()));
    EXPECT_EQ(folder.entries(), 1u);
}

TEST(VdbStore, ThreadsReadAndWriteAtOnce) {
    const Folder folder;
    ASSERT_TRUE(write_field(example_field(), folder.file()));
    const std::string wanted = file_bytes(folder.file());
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&] {
            for (int i = 0; i < 3; ++i) {
                EXPECT_TRUE(write_field(example_field(), folder.file()));
                EXPECT_TRUE(read_field(folder.file()));
            }
        });
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(file_bytes(folder.file()), wanted);
    EXPECT_EQ(folder.entries(), 1u);
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
    const Folder folder;
    ASSERT_TRUE(write_field(example_field(), folder.file()));
    const path errors = folder.file("errors");
    const std::string listing =
        output_of("vdb_print -l '" + folder.file().string() + "' 2>'" + errors.string() + "'");
    EXPECT_EQ(file_bytes(errors), "");
    for (const char* grid :
         {"ambient_visibility", "planar_handles", "spherical_handles", "local_handles", "quadtree_pool"})
        EXPECT_NE(listing.find(grid), std::string::npos) << grid << " is missing in:\n" << listing;
    EXPECT_NE(listing.find("fog volume"), std::string::npos) << listing;
}

TEST(VdbStore, PyopenvdbReadsAmbientVisibilityByName) {
    const std::string python = "/usr/bin/python3";
    if (output_of(python + " -c 'import pyopenvdb; print(1)' 2>/dev/null").empty())
        GTEST_SKIP() << "pyopenvdb is not installed";
    const Folder folder;
    ASSERT_TRUE(write_field(example_field(), folder.file()));
    const std::string script =
        "import pyopenvdb as vdb\n"
        "grid = vdb.read('" +
        folder.file().string() +
        "', 'ambient_visibility')\n"
        "voxels = [v.value for v in grid.citerOnValues()]\n"
        "print(grid.background, len(voxels) > 1000, 0 <= min(voxels) < max(voxels) < 1,\n"
        "      grid.getAccessor().getValue(tuple(int(c) for c in grid.transform.worldToIndex((-50, 9, "
        "2)))),\n"
        "      grid.getAccessor().getValue(tuple(round(c) for c in grid.transform.worldToIndex((0, 0.7, "
        "0)))))\n";
    write_bytes(folder.file("read.py"), script);
    EXPECT_EQ(output_of(python + " '" + folder.file("read.py").string() + "' 2>&1"),
              "1.0 True True 1.0 0.0\n");
}

TEST(AmbientVisibility, MeanOverDirectionsIsTheSumOfTexelsTimesSolidAngles) {
    for (const VisibilityField& field : {example_field(), random_field(3, 0)}) {
        const int size = field.pool.face_size;
        const std::vector<float> means = mean_over_directions(field.pool);
        ASSERT_EQ(means.size(), field.pool.cubemaps.size());
        for (std::size_t handle = 0; handle < means.size(); handle += 1 + means.size() / 50) {
            double sum = 0;
            for (const std::uint32_t face : field.pool.cubemaps[handle]) {
                const std::vector<float> texels = quadtree_texels(unpacked_face(field.pool, face), size);
                for (int i = 0; i < size * size; ++i)
                    sum += double(texels[std::size_t(i)]) * texel_solid_angle(i % size, i / size, size);
            }
            EXPECT_NEAR(means[handle], sum / (4 * pi), 1e-6) << "handle " << handle;
        }
    }
}

TEST(AmbientVisibility, OfASphereIsWhatItsConeLeavesOpen) {
    const float radius = 0.5f;
    const Vec3f centre(1, 2, 3);
    const PreparedMesh mesh = prepared_as_is(sphere_mesh(centre, radius, 16));
    const VisibilityField field =
        *precompute_field("sphere", mesh, EntityOcclusion(mesh), {32, 0, 0, 6, 4000});
    const AmbientVisibility volume = ambient_visibility(field);
    ASSERT_EQ(volume.size, (std::array<std::int32_t, 3>{41, 41, 41}));
    ASSERT_EQ(volume.values.size(), 41u * 41 * 41);
    const Vec3f margin(0.5f * field.bounds.radius());
    EXPECT_TRUE(volume.origin.equalWithAbsError(field.bounds.lower - margin, 1e-5f)) << volume.origin;
    EXPECT_TRUE((volume.origin + Vec3f(40 * volume.voxel_size))
                    .equalWithAbsError(field.bounds.upper + margin, 1e-5f));
    std::size_t i = 0;
    int outside = 0;
    for (int x = 0; x <= 40; ++x)
        for (int y = 0; y <= 40; ++y)
            for (int z = 0; z <= 40; ++z, ++i) {
                const Vec3f place = volume.origin + Vec3f(float(x), float(y), float(z)) * volume.voxel_size;
                const double distance = (place - centre).length();
                // Nearer to the surface a cell of the sampler has corners in and out of the sphere.
                if (distance > 1.6 * radius) {
                    const double sine = radius / distance;
                    EXPECT_NEAR(volume.values[i], (1 + std::sqrt(1 - sine * sine)) / 2, 0.03)
                        << x << " " << y << " " << z;
                    ++outside;
                } else if (distance < 0.6 * radius) {
                    EXPECT_EQ(volume.values[i], 0.0f) << x << " " << y << " " << z;
                }
            }
    EXPECT_GT(outside, 5000);
}

}  // namespace
}  // namespace haarfield
