#include "fields/field/field_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <random>
#include <thread>

#include "fields/base/sanitizers.h"
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
    // Vertices fill leaves of 2^9 and nodes of 2^21 voxels.
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

/// A change may hit what is no part of the field, such as the UUID or a transform.
TEST(FieldFile, AChangedByteIsRefusedOrChangesNothing) {
    if (is_thread_sanitized) GTEST_SKIP() << "allocations that fail end the process";
    const TestFolder folder;
    const VisibilityField field = example_field();
    ASSERT_TRUE(write_field(field, folder / "example.vdb"));
    const std::string bytes = text_of(folder / "example.vdb");
    std::mt19937 random(2006);
    int refused = 0;
    for (int i = 0; i < 500; ++i) {
        const std::size_t place = random() % bytes.size();
        std::string changed = bytes;
        changed[place] = static_cast<char>(changed[place] ^ (1 << random() % 8));
        write_text(folder / "changed.vdb", changed);
        const Result<VisibilityField> read = read_field(folder / "changed.vdb");
        if (read)
            expect_same(*read, field, "byte " + std::to_string(place));
        else
            ++refused;
    }
    EXPECT_GT(refused, 400);
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
