#include "fields/field/field_library.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "fields/file/section_file.h"
#include "tests/fixtures/field_fixtures.h"
#include "tests/fixtures/test_folder.h"

namespace haarfield {
namespace {

using std::chrono::hours;
using std::filesystem::path;
using Clock = std::chrono::system_clock;

/// Returns a field of an entity with this name; the library supplies its keys.
VisibilityField named_field(const std::string& entity, std::uint32_t seed) {
    VisibilityField field = random_field(seed, 20);
    field.entity = entity;
    return field;
}

Result<LibraryField> taken(const path& folder, const VisibilityField& field, int& made) {
    return library_field(folder, field.entity, field.keys, [&](const PrecomputedSamples&) {
        ++made;
        return Result<VisibilityField>(field);
    });
}

TEST(FieldLibrary, FindsAFieldByItsKeysUnderAnyName) {
    const TestFolder folder;
    const VisibilityField chair = named_field("chair", 1), other = named_field("chair", 2);
    int made = 0;
    const auto first = taken(folder.path(), chair, made);
    ASSERT_TRUE(first) << first.error().message();
    EXPECT_FALSE(first->reused);
    EXPECT_EQ(first->file, library_file(folder.path(), "chair", chair.keys));
    EXPECT_TRUE(first->file.filename().string().starts_with("chair-")) << first->file;
    ASSERT_TRUE(taken(folder.path(), other, made)) << "a different field with that name";
    EXPECT_EQ(made, 2);
    EXPECT_EQ(folder.files().size(), 2u);
    VisibilityField renamed = chair;
    renamed.entity = "stool";
    const auto again = taken(folder.path(), renamed, made);
    ASSERT_TRUE(again);
    EXPECT_TRUE(again->reused);
    EXPECT_EQ(again->file, first->file);
    EXPECT_EQ(made, 2);
    expect_same(again->field, chair, "read again");
    EXPECT_TRUE(has_library_field(folder.path(), chair.keys));
    EXPECT_FALSE(has_library_field(folder.path(), named_field("chair", 3).keys));
}

TEST(FieldLibrary, PassesKnownSurroundings) {
    const TestFolder folder;
    const VisibilityField coarse = named_field("lamp", 4);
    int made = 0;
    ASSERT_TRUE(taken(folder.path(), coarse, made));
    FieldKeys finer = coarse.keys;
    finer.whole.low ^= 1;
    finer.whole.high ^= 1;
    const auto field = library_field(folder.path(), "lamp", finer, [&](const PrecomputedSamples& known) {
        EXPECT_EQ(known.runs.size(), 1u);
        if (known.runs.size() == 1) {
            EXPECT_EQ(known.runs[0].first, 0u);
            EXPECT_EQ(known.runs[0].handles.size(),
                      coarse.planar_handles.size() + coarse.spherical_handles.size());
        }
        EXPECT_TRUE(known.error && *known.error == coarse.error);
        VisibilityField result = coarse;
        result.keys = finer;
        return Result<VisibilityField>(result);
    });
    ASSERT_TRUE(field);
    EXPECT_TRUE(field->surroundings_reused);
    EXPECT_FALSE(field->reused);
}

TEST(FieldLibrary, ReplacesDamagedAndWronglyNamedFiles) {
    const TestFolder folder;
    const VisibilityField chair = named_field("chair", 1);
    int made = 0;
    const path file = taken(folder.path(), chair, made)->file;
    const std::string whole = text_of(file);
    write_text(file, whole.substr(0, whole.size() / 2));
    const path moved = folder / ("old" + file.filename().string());
    std::filesystem::rename(file, moved);
    const auto remade = taken(folder.path(), chair, made);
    ASSERT_TRUE(remade);
    EXPECT_NE(remade->recomputed_because, "");
    EXPECT_EQ(remade->file, moved);
    EXPECT_TRUE(text_of(moved) == whole);
    const VisibilityField other = named_field("chair", 2);
    std::filesystem::rename(moved, library_file(folder.path(), "chair", other.keys));
    const auto misnamed = taken(folder.path(), other, made);
    ASSERT_TRUE(misnamed);
    EXPECT_NE(misnamed->recomputed_because.find("different field"), std::string::npos)
        << misnamed->recomputed_because;
    EXPECT_TRUE(taken(folder.path(), other, made)->reused);
    EXPECT_EQ(folder.files().size(), 1u);
}

TEST(FieldLibrary, ManyThreadsMakeAFieldOnce) {
    const TestFolder folder;
    const VisibilityField chair = named_field("chair", 1);
    std::atomic<int> made = 0;
    std::vector<std::thread> threads;
    for (int t = 0; t < 6; ++t)
        threads.emplace_back([&] {
            const auto field =
                library_field(folder.path(), "chair", chair.keys, [&](const PrecomputedSamples&) {
                    ++made;
                    std::this_thread::sleep_for(std::chrono::milliseconds(30));
                    return Result<VisibilityField>(chair);
                });
            EXPECT_TRUE(field);
        });
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(made, 1);
    EXPECT_EQ(folder.files().size(), 1u);
}

TEST(FieldLibrary, ListsFieldsAndUnreadableFiles) {
    const TestFolder folder;
    EXPECT_FALSE(library_entries(folder / "missing"));
    int made = 0;
    const VisibilityField field = named_field("chair", 1);
    ASSERT_TRUE(taken(folder.path(), field, made));
    write_text(folder / "zebra.vdb", "no field");
    write_text(folder / "notes.txt", "not listed");
    write_text(folder / "table-00.haarmesh", section_file({{"entity", "table"}, {"mesh", ""}}));
    const auto entries = library_entries(folder.path());
    ASSERT_TRUE(entries);
    ASSERT_EQ(entries->size(), 3u);
    const LibraryEntry& chair = (*entries)[0];
    EXPECT_EQ(chair.trouble, "");
    EXPECT_EQ(chair.entity, "chair");
    EXPECT_TRUE(chair.card->keys == field.keys);
    EXPECT_EQ(chair.card->planar_samples, field.planar_handles.size());
    EXPECT_EQ(chair.card->spherical_samples, field.spherical_handles.size());
    EXPECT_EQ(chair.card->local_samples, field.local_handles.size());
    EXPECT_EQ(chair.card->error, field.error);
    EXPECT_EQ(chair.bytes, std::filesystem::file_size(chair.file));
    EXPECT_TRUE(verify_entry(chair));
    EXPECT_NE((*entries)[1].trouble, "");
    const LibraryEntry& table = (*entries)[2];
    EXPECT_EQ(table.trouble, "");
    EXPECT_EQ(table.entity, "table");
    EXPECT_FALSE(table.card);
    EXPECT_FALSE(verify_entry(table)) << "it has no mesh";
}

TEST(FieldLibrary, AUseIsNoted) {
    const TestFolder folder;
    int made = 0;
    const VisibilityField field = named_field("chair", 1);
    const path file = taken(folder.path(), field, made)->file;
    const auto long_ago = std::filesystem::file_time_type::clock::now() - hours(1000);
    std::filesystem::last_write_time(file, long_ago);
    ASSERT_TRUE(taken(folder.path(), field, made)->reused);
    EXPECT_GT(std::filesystem::last_write_time(file), long_ago + hours(999));
}

TEST(FieldLibrary, PruningRemovesTheLeastRecentlyUsed) {
    const Clock::time_point now = Clock::now();
    std::vector<LibraryEntry> entries;
    for (const int age : {5, 50, 1, 500}) entries.push_back({std::to_string(age), 100, now - hours(age)});
    const auto pruned = [&](const LibraryPruning& pruning) {
        std::string names;
        for (const LibraryEntry& entry : pruned_entries(entries, pruning, now))
            names += entry.file.string() + " ";
        return names;
    };
    EXPECT_EQ(pruned({}), "");
    EXPECT_EQ(pruned({hours(20), {}}), "500 50 ");
    EXPECT_EQ(pruned({hours(1000), {}}), "");
    EXPECT_EQ(pruned({{}, 400}), "");
    EXPECT_EQ(pruned({{}, 399}), "500 ");
    EXPECT_EQ(pruned({{}, 150}), "500 50 5 ");
    EXPECT_EQ(pruned({{}, 0}), "500 50 5 1 ");
    EXPECT_EQ(pruned({hours(100), 250}), "500 50 ");
}

}  // namespace
}  // namespace haarfield
