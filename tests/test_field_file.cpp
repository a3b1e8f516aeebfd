#include "fields/field/field_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <cstring>
#include <random>
#include <thread>

#include "fields/field/field_seal.h"
#include "tests/fixtures/field_fixtures.h"
#include "tests/fixtures/test_folder.h"

namespace haarfield {
namespace {

using std::filesystem::path;

void expect_round_trip(const VisibilityField& field, const std::string& which) {
    const TestFolder folder;
    const Result<Done> written = write_field(field, folder / "example.vdb");
    ASSERT_TRUE(written) << which << ": " << written.error().message();
    const Result<VisibilityField> read = read_field(folder / "example.vdb");
    ASSERT_TRUE(read) << which << ": " << read.error().message();
    expect_same(*read, field, which);
}

TEST(FieldFile, FieldsRoundTripBitForBit) {
    expect_round_trip(example_field(), "example");
    // Vertices fill bricks of 2^9, rows of bricks of 2^13 and layers of 2^17.
    std::uint32_t seed = 0;
    for (const std::size_t vertices : {0, 1, 511, 513, 9000, 140000})
        expect_round_trip(random_field(++seed, vertices), std::to_string(vertices) + " vertices");
}

TEST(FieldFile, EqualFieldsMakeEqualFiles) {
    const TestFolder folder;
    ASSERT_TRUE(write_field(example_field(), folder / "a.vdb"));
    ASSERT_TRUE(write_field(example_field(), folder / "b.vdb"));
    EXPECT_EQ(text_of(folder / "a.vdb"), text_of(folder / "b.vdb"));
    ASSERT_TRUE(write_field(random_field(1, 10), folder / "b.vdb"));
    EXPECT_NE(text_of(folder / "a.vdb").substr(21, 36), text_of(folder / "b.vdb").substr(21, 36));
}

TEST(FieldFile, SummaryCountsTheContent) {
    const TestFolder folder;
    const VisibilityField field = random_field(5, 700);
    ASSERT_TRUE(write_field(field, folder / "example.vdb"));
    const Result<FieldSummary> summary = read_field_summary(folder / "example.vdb");
    ASSERT_TRUE(summary) << summary.error().message();
    EXPECT_EQ(summary->entity, field.entity);
    EXPECT_TRUE(summary->keys == field.keys);
    EXPECT_EQ(summary->settings, field.settings);
    EXPECT_EQ(summary->planar.rings, field.planar.rings);
    EXPECT_EQ(summary->spherical.azimuths, field.spherical.azimuths);
    EXPECT_EQ(summary->local_samples, 700u);
    EXPECT_EQ(summary->nodes, node_count(field.pool));
    EXPECT_EQ(summary->faces, field.pool.faces.size());
    EXPECT_EQ(summary->cubemaps, 50u);
    EXPECT_EQ(summary->file_bytes, std::filesystem::file_size(folder / "example.vdb"));
    EXPECT_TRUE(verify_field(folder / "example.vdb"));
}

/// Expects all functions that read a whole file to reject it.
void expect_refused(const path& file, const std::string& which) {
    const Result<VisibilityField> field = read_field(file);
    ASSERT_FALSE(field) << which;
    EXPECT_EQ(field.error().where, file.string());
    EXPECT_FALSE(field.error().what.empty());
    EXPECT_FALSE(verify_field(file)) << which;
}

TEST(FieldFile, RefusesAFileCutShortAnywhere) {
    const TestFolder folder;
    ASSERT_TRUE(write_field(example_field(), folder / "example.vdb"));
    const std::string bytes = text_of(folder / "example.vdb");
    const std::size_t step = bytes.size() / 300;
    for (std::size_t size = 0; size < bytes.size();
         size += bytes.size() - size <= 130 || size < 130 ? 1 : step) {
        write_text(folder / "cut.vdb", std::string_view(bytes).substr(0, size));
        expect_refused(folder / "cut.vdb", std::to_string(size) + " bytes");
    }
}

TEST(FieldFile, RefusesAFileWithAChangedByte) {
    const TestFolder folder;
    ASSERT_TRUE(write_field(example_field(), folder / "example.vdb"));
    const std::string bytes = text_of(folder / "example.vdb");
    std::mt19937 random(2006);
    for (int i = 0; i < 500; ++i) {
        // A seventh of the changes are in the seal.
        const std::size_t place =
            i % 7 == 0 ? bytes.size() - 1 - random() % field_seal_size : random() % bytes.size();
        std::string changed = bytes;
        changed[place] = static_cast<char>(changed[place] ^ (1 << random() % 8));
        write_text(folder / "changed.vdb", changed);
        expect_refused(folder / "changed.vdb", "byte " + std::to_string(place));
    }
}

TEST(FieldFile, RefusesOtherFiles) {
    const TestFolder folder;
    expect_refused(folder / "missing.vdb", "missing file");
    expect_refused(folder.path(), "folder");
    expect_refused("/dev/null", "device");
    write_text(folder / "example.vdb", "");
    expect_refused(folder / "example.vdb", "empty file");
    write_text(folder / "example.vdb", std::string(1000, 'x'));
    expect_refused(folder / "example.vdb", "text");
    // A sealed file that OpenVDB cannot read.
    const std::string text(1000, 'x');
    write_text(folder / "example.vdb", text + field_seal(text, text));
    expect_refused(folder / "example.vdb", "sealed text");
    write_text(folder / "example.vdb", field_seal({}, {}));
    expect_refused(folder / "example.vdb", "lone seal");
}

TEST(FieldFile, ReadsUnsealedFilesOnlyIfAllowed) {
    const TestFolder folder;
    const path file = folder / "unsealed.vdb";
    const VdbFile whole = *vdb_file(example_field());
    write_text(file, whole.bytes);
    const Result<VisibilityField> refused = read_field(file);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().what.find("saved by another program"), std::string::npos)
        << refused.error().what;

    // At any offset of the tables.
    for (const std::size_t shift : {0, 1, 2, 4, 63}) {
        write_text(file, "HAARBLOB" + std::string(56 + shift, 'x') + whole.bytes);
        const Result<VisibilityField> read = read_field(file, Unsealed::allowed);
        ASSERT_TRUE(read) << read.error().message();
        expect_same(*read, example_field(), "moved by " + std::to_string(shift));
    }
    const Result<FieldVerdict> verdict = verify_field(file, Unsealed::allowed);
    ASSERT_TRUE(verdict) << verdict.error().message();
    EXPECT_FALSE(verdict->sealed);
    EXPECT_FALSE(verdict->grids_compared);
    EXPECT_FALSE(read_field_summary(file, Unsealed::allowed)->sealed);

    for (const std::size_t offset : {whole.blob_offset + 9, whole.blob_offset + 100, section_offset(whole, 0),
                                     section_offset(whole, 5), whole.blob_offset + whole.blob_bytes - 1}) {
        std::string changed = whole.bytes;
        changed[offset] = static_cast<char>(changed[offset] ^ 1);
        write_text(file, changed);
        EXPECT_FALSE(read_field(file, Unsealed::allowed)) << offset;
    }
    for (std::size_t size = 0; size < whole.blob_offset + whole.blob_bytes; size += 997) {
        write_text(file, std::string_view(whole.bytes).substr(0, size));
        EXPECT_FALSE(read_field(file, Unsealed::allowed)) << size;
    }
    // A seal must be valid if there is one.
    std::string sealed = forged_file(whole);
    for (const std::size_t offset : {whole.blob_offset / 2, sealed.size() - 1, sealed.size() - 50}) {
        std::string changed = sealed;
        changed[offset] = static_cast<char>(changed[offset] ^ 1);
        write_text(file, changed);
        EXPECT_FALSE(read_field(file, Unsealed::allowed)) << offset;
    }
}

TEST(FieldFile, AFieldOutlivesItsFile) {
    const TestFolder folder;
    ASSERT_TRUE(write_field(example_field(), folder / "example.vdb"));
    const Result<VisibilityField> read = read_field(folder / "example.vdb");
    ASSERT_TRUE(read);
    ASSERT_TRUE(write_field(random_field(1, 10), folder / "example.vdb"));
    expect_same(*read, example_field(), "replaced");
    std::filesystem::remove(folder / "example.vdb");
    const VisibilityField copy = *read;
    expect_same(copy, example_field(), "removed");
    EXPECT_EQ(copy.pool.node_bytes.data(), read->pool.node_bytes.data());
    for (const void* table : {static_cast<const void*>(copy.pool.node_bytes.data()),
                              static_cast<const void*>(copy.pool.faces.data()),
                              static_cast<const void*>(copy.pool.cubemaps.data())})
        EXPECT_EQ(reinterpret_cast<std::uintptr_t>(table) % 64, 0u) << "copied from the file";
}

template <class T>
VdbFile with_value(VdbFile file, std::size_t offset, T value) {
    std::memcpy(file.bytes.data() + offset, &value, sizeof value);
    return file;
}

TEST(FieldFile, RefusesForgedTables) {
    const TestFolder folder;
    const path file = folder / "forged.vdb";
    const VisibilityField field = random_field(7, 100);
    const VdbFile whole = *vdb_file(field);
    write_text(file, forged_file(whole));
    ASSERT_TRUE(read_field(file)) << "not forged at all";

    enum Table : std::size_t { entity, record, planar, spherical, local, cubemaps, faces, nodes };
    const auto at = [&](Table table, std::size_t offset = 0) {
        return section_offset(whole, table) + offset;
    };
    const auto listed = [&](Table table) { return whole.blob_offset + 24 + 32 * table; };
    const std::size_t blob = whole.blob_offset;
    const auto forged = [&](std::size_t offset, auto value) { return with_value(whole, offset, value); };
    using Handle = std::int32_t;
    const std::pair<const char*, VdbFile> forgeries[] = {
        {"another version", forged(blob + 8, std::uint32_t(1))},
        {"more sections", forged(blob + 12, std::uint32_t(9))},
        {"a longer blob", forged(blob + 16, ~std::uint64_t(0))},
        {"a section of another name", forged(listed(faces), 'F')},
        {"a section elsewhere", forged(listed(nodes) + 8, std::uint64_t(1) << 60)},
        {"a section of 2^64 bytes", forged(listed(nodes) + 16, ~std::uint64_t(0))},
        {"a section of 2^63 bytes", forged(listed(cubemaps) + 16, std::uint64_t(1) << 63)},
        {"something before a section", forged(at(entity) - 1, 'x')},
        {"face size 0", forged(at(record, 32), 0)},
        {"face size 2", forged(at(record, 32), 2)},
        {"face size 48", forged(at(record, 32), 48)},
        {"bounds not a number", forged(at(record, 52), NAN)},
        {"2^31 - 1 rings", forged(at(record, 88), 0x7fffffff)},
        {"-1 rings", forged(at(record, 88), -1)},
        {"0 rings", forged(at(record, 88), 0)},
        {"one ring less", forged(at(record, 88), field.planar.rings - 1)},
        {"one ring more", forged(at(record, 88), field.planar.rings + 1)},
        {"0 angles", forged(at(record, 92), 0)},
        {"infinite outer radius", forged(at(record, 96), INFINITY)},
        {"2^20 shells", forged(at(record, 116), 1 << 20)},
        {"-3 azimuths", forged(at(record, 124), -3)},
        {"a planar handle beyond the last", forged(at(planar, 4), Handle(50))},
        {"a negative spherical handle", forged(at(spherical, 8), Handle(-1))},
        {"a local handle beyond the last", forged(at(local, 396), Handle(0x7fffffff))},
        {"a face beyond the last", forged(at(cubemaps, 8), 1u << 20)},
        {"a face with nodes beyond the last", forged(at(faces), ~0u)},
        {"nodes that nothing leads to", forged(at(nodes), std::uint8_t(0x70))},
        {"a child beyond the last", forged(at(nodes, 4), std::uint8_t(0x71))},
        {"a node of no kind", forged(at(nodes), std::uint8_t(0xff))},
        {"a handle less", forged(listed(local) + 16, std::uint64_t(396))},
        {"half a handle less", forged(listed(local) + 16, std::uint64_t(398))},
        {"half a cubemap less", forged(listed(cubemaps) + 16, std::uint64_t(50 * 24 - 12))},
    };
    for (const auto& [which, forgery] : forgeries) {
        ASSERT_NE(forgery.bytes, whole.bytes) << which;
        write_text(file, forged_file(forgery));
        expect_refused(file, which);
    }
}

TEST(FieldFile, RefusesASealThatPointsElsewhere) {
    const TestFolder folder;
    const path file = folder / "forged.vdb";
    const VdbFile whole = *vdb_file(random_field(7, 100));
    const std::string_view bytes = whole.bytes;
    for (const std::size_t shift : {1u, 8u, 64u}) {
        write_text(
            file, whole.bytes + field_seal(bytes, bytes.substr(whole.blob_offset - shift, whole.blob_bytes)));
        expect_refused(file, "a blob " + std::to_string(shift) + " bytes before");
    }
    write_text(file, whole.bytes + field_seal(bytes, bytes.substr(whole.blob_offset, whole.blob_bytes - 1)));
    expect_refused(file, "a byte less");
    write_text(file, whole.bytes + field_seal(bytes, std::string_view(bytes.data() + bytes.size() - 8, 64)));
    expect_refused(file, "a blob beyond the end");
}

TEST(FieldFile, ForgedTablesAreRefusedOrHarmless) {
    const TestFolder folder;
    const path file = folder / "forged.vdb";
    const VdbFile whole = *vdb_file(random_field(11, 100));
    std::mt19937 random(7);
    int refused = 0;
    for (int i = 0; i < 500; ++i) {
        VdbFile forgery = whole;
        for (std::uint32_t changes = 1 + random() % 3; changes > 0; --changes)
            forgery.bytes[whole.blob_offset + random() % whole.blob_bytes] = static_cast<char>(random());
        write_text(file, forged_file(forgery));
        const Result<VisibilityField> field = read_field(file);
        if (field)
            EXPECT_EQ(field_defect(*field), "");
        else
            ++refused;
    }
    EXPECT_GT(refused, 100);
    EXPECT_LT(refused, 500);
}

TEST(FieldFile, GridsAreIgnoredInReadingAndComparedInVerifying) {
    const TestFolder folder;
    const path file = folder / "forged.vdb";
    const VisibilityField field = random_field(13, 100);
    const VdbFile whole = *vdb_file(field);
    for (const std::size_t offset : {std::size_t(0), std::size_t(30), std::size_t(300), whole.blob_offset / 2,
                                     whole.blob_offset + whole.blob_bytes + 70, whole.bytes.size() - 1}) {
        write_text(file, forged_file(with_value(whole, offset, static_cast<char>(~whole.bytes[offset]))));
        const Result<VisibilityField> read = read_field(file);
        ASSERT_TRUE(read) << read.error().message();
        expect_same(*read, field, "changed at " + std::to_string(offset));
        EXPECT_FALSE(verify_field(file)) << offset;
    }
    // Another version of OpenVDB may write equal grids differently.
    write_text(file, forged_file(with_value(whole, 16, std::uint32_t(99))));
    const Result<FieldVerdict> verdict = verify_field(file);
    ASSERT_TRUE(verdict) << verdict.error().message();
    EXPECT_TRUE(verdict->sealed);
    EXPECT_FALSE(verdict->grids_compared);
}

/// Limits the size of all files while it exists, as on a full disk.
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

TEST(FieldFile, AFullDiskLeavesTheFolderAsItWas) {
    const TestFolder folder;
    ASSERT_TRUE(write_field(example_field(), folder / "example.vdb"));
    const std::string before = text_of(folder / "example.vdb");
    VisibilityField other = example_field();
    other.entity = "other";
    for (const double part : {0.0, 0.1, 0.5, 0.9, 0.9999}) {
        const auto bytes = static_cast<rlim_t>(part * double(before.size()));
        const Result<Done> written = [&] {
            const SizeLimit limit(bytes);
            return write_field(other, folder / "example.vdb");
        }();
        ASSERT_FALSE(written) << bytes << " bytes";
        EXPECT_EQ(written.error().where, (folder / "example.vdb").string());
        EXPECT_EQ(text_of(folder / "example.vdb"), before);
        EXPECT_EQ(folder.files().size(), 1u);
    }
    ASSERT_TRUE(write_field(other, folder / "example.vdb"));
    EXPECT_EQ(read_field(folder / "example.vdb")->entity, "other");
    EXPECT_EQ(folder.files().size(), 1u);
}

TEST(FieldFile, RefusesToWriteADefectOrIntoNoFolder) {
    const TestFolder folder;
    EXPECT_FALSE(write_field(example_field(), folder / "missing" / "example.vdb"));
    std::filesystem::create_directory(folder / "folder");
    EXPECT_FALSE(write_field(example_field(), folder / "folder"));
    VisibilityField field = example_field();
    field.local_handles[0] = static_cast<std::int32_t>(field.pool.cubemaps.size());
    EXPECT_FALSE(write_field(field, folder / "example.vdb"));
    EXPECT_EQ(folder.files().size(), 1u);
}

TEST(FieldFile, ThreadsReadAndWriteAtOnce) {
    const TestFolder folder;
    ASSERT_TRUE(write_field(example_field(), folder / "example.vdb"));
    const std::string wanted = text_of(folder / "example.vdb");
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&] {
            for (int i = 0; i < 3; ++i) {
                EXPECT_TRUE(write_field(example_field(), folder / "example.vdb"));
                EXPECT_TRUE(read_field(folder / "example.vdb"));
            }
        });
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(text_of(folder / "example.vdb"), wanted);
    EXPECT_EQ(folder.files().size(), 1u);
}

}  // namespace
}  // namespace haarfield
