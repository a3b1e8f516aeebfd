// The sources of fields/file/portable, which replace those for Linux in this program.

#include <gtest/gtest.h>

#include <chrono>

#include "fields/file/claim.h"
#include "fields/file/process_name.h"
#include "fields/file/reader_process.h"
#include "fields/file/temporary_file.h"
#include "fields/file/this_process.h"
#include "fields/model/mesh_reader.h"
#include "tests/fixtures/test_folder.h"

namespace haarfield {
namespace {

TEST(PortableSystem, RefusesUntrustedFilesUntilTheyAreAllowed) {
    const TestFolder folder;
    const std::filesystem::path file = folder / "triangle.obj";
    write_text(file, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    const auto refused = read_mesh(file);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message().find("there is no sandbox for untrusted files on this system"),
              std::string::npos)
        << refused.error().message();
    EXPECT_NE(refused.error().message().find("--unsandboxed"), std::string::npos);
    allow_unsandboxed_readers();
    const auto read = read_mesh(file);
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ(read->mesh.triangles.size(), 1u);
}

TEST(PortableSystem, MakesNoClaims) {
    const TestFolder folder;
    for (int i = 0; i < 2; ++i) {
        const auto claim = Claim::on(folder / "work.claim");
        ASSERT_TRUE(claim);
        EXPECT_FALSE(*claim);
    }
    EXPECT_FALSE(exists(folder / "work.claim"));
}

TEST(PortableSystem, KnowsItsOwnNameAndNoOther) {
    EXPECT_EQ(process_name(), process_name());
    EXPECT_EQ(process_liveness(process_name()), Liveness::alive);
    EXPECT_EQ(process_liveness("0123456789ab-1-1"), Liveness::unknown);
}

TEST(PortableSystem, RemovesTemporaryFilesOfOtherProcessesAfterADay) {
    const TestFolder folder;
    const auto own = TemporaryFile::beside(folder / "own");
    ASSERT_TRUE(own) << own.error().message();
    write_text(folder / "target.0123456789ab-1-1.0.tmp", "new");
    write_text(folder / "target.0123456789ab-1-1.1.tmp", "old");
    last_write_time(folder / "target.0123456789ab-1-1.1.tmp",
                    std::filesystem::file_time_type::clock::now() - std::chrono::hours(25));
    remove_abandoned_files(folder.path());
    EXPECT_EQ(folder.files().size(), 2u);
    EXPECT_FALSE(exists(folder / "target.0123456789ab-1-1.1.tmp"));
}

TEST(PortableSystem, NamesTheProgram) {
    EXPECT_EQ(running_program(), "haarfield");
    end_with_parent();
}

}  // namespace
}  // namespace haarfield
