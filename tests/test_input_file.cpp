#include "fields/file/input_file.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>

#include "fields/base/sanitizers.h"
#include "fields/field/field_file.h"
#include "fields/file/mapped_file.h"
#include "fields/file/section_file.h"
#include "fields/model/mesh_reader.h"
#include "fields/vdb/vdb_file.h"
#include "scenes/image.h"
#include "scenes/scene_reader.h"
#include "tests/fixtures/field_fixtures.h"
#include "tests/fixtures/test_folder.h"

namespace haarfield {
namespace {

using std::filesystem::path;

/// Returns the error of each reader of files, by name.
std::vector<std::pair<std::string, std::string>> errors_of_readers(const path& file) {
    std::vector<std::pair<std::string, std::string>> errors;
    const auto note = [&](const std::string& reader, const auto& result) {
        errors.emplace_back(reader, result ? "no error" : result.error().message());
    };
    note("scene", read_scene(file));
    note("mesh", read_mesh(file));
    note("image", read_image(file));
    note("field", read_field(file));
    note("grids", read_vdb_listing(file));
    note("leaves", read_vdb_leaves(file, "faces"));
    note("card of a field", read_field_card(file));
    note("sections", read_section_file(file));
    note("first section", read_first_section(file));
    note("mapped file", mapped_file(file));
    note("whole file", read_whole_file(file, std::uint64_t{1} << 20));
    return errors;
}

TEST(InputFile, EveryReaderNamesTheTypeOfIrregularFiles) {
    const TestFolder folder;
    ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
    std::filesystem::create_symlink(folder / "pipe", folder / "link");
    const int listener = socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un address{AF_UNIX, {}};
    std::strncpy(address.sun_path, (folder / "socket").c_str(), sizeof address.sun_path - 1);
    ASSERT_EQ(bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    close(listener);
    for (const auto& [file, expected] : {std::pair<path, const char*>{folder.path(), "is a directory"},
                                         {folder / "pipe", "is a pipe"},
                                         {folder / "link", "is a pipe"},
                                         {folder / "socket", "is a socket"},
                                         {"/dev/null", "is a device"},
                                         {folder / "nothing", "there is no such file"},
                                         {folder / "pipe/nothing", "there is no such file"}})
        for (const auto& [reader, error] : errors_of_readers(file))
            EXPECT_NE(error.find(expected), std::string::npos) << reader << " of " << file << ": " << error;
}

TEST(InputFile, AFileThatMayNotBeReadIsNotCalledMissing) {
    const TestFolder folder;
    write_text(folder / "secret", "secret");
    std::filesystem::permissions(folder / "secret", std::filesystem::perms::none);
    // Root may read every file.
    constexpr uid_t nobody = 65534;
    const uid_t user = geteuid();
    ASSERT_TRUE(user != 0 || seteuid(nobody) == 0);
    const auto errors = errors_of_readers(folder / "secret");
    ASSERT_TRUE(user != 0 || seteuid(user) == 0);
    for (const auto& [reader, error] : errors)
        EXPECT_NE(error.find("Permission denied"), std::string::npos) << reader << ": " << error;
}

TEST(InputFile, FilesOfUnknownSizeAreReadUpToALimit) {
    const Result<std::string> status = read_whole_file("/proc/self/status", std::uint64_t{1} << 20);
    ASSERT_TRUE(status) << status.error().message();
    EXPECT_NE(status->find("Pid:"), std::string::npos);
    const TestFolder folder;
    write_text(folder / "large", std::string((std::size_t{1} << 20) + 1, 'x'));
    const Result<std::string> large = read_whole_file(folder / "large", std::uint64_t{1} << 20);
    ASSERT_FALSE(large);
    EXPECT_NE(large.error().what.find("larger than 1 MiB"), std::string::npos) << large.error().message();
}

/// Extends a file without allocating data. False if the file system does not support it.
bool lengthen(const path& file) {
    constexpr off_t terabyte = off_t{1} << 40;
    return truncate(file.c_str(), terabyte) == 0;
}

/// True for readers that ignore what follows the grids of a file, if their process can map all of it.
/// Sanitizers do not permit a limit of its address space.
bool may_map_a_terabyte(const std::string& reader) {
    return has_shadow_memory && (reader == "grids" || reader == "leaves");
}

/// Reading a terabyte would take minutes.
TEST(InputFile, SparseFilesOfATerabyteAreRefusedByTheirHeaders) {
    const TestFolder folder;
    ASSERT_TRUE(write_field(example_field(), folder / "field.vdb"));
    const std::string field = text_of(folder / "field.vdb"),
                      sections = section_file({{"one", "first"}, {"two", "second"}});
    for (const std::string& begin :
         {std::string(), field, sections, std::string("{"), std::string("solid "), std::string("ply\n"),
          std::string("v 1 2 3\n"), std::string("\x89PNG\r\n\x1a\n")}) {
        write_text(folder / "sparse", begin);
        if (!lengthen(folder / "sparse")) GTEST_SKIP() << "no files of a terabyte here";
        for (const auto& [reader, error] : errors_of_readers(folder / "sparse")) {
            const bool may_read = (reader == "first section" && begin == sections) ||
                                  (may_map_a_terabyte(reader) && begin == field);
            if (!may_read) {
                EXPECT_NE(error, "no error")
                    << reader << " of a file that begins with " << begin.substr(0, 8);
            }
        }
    }
}

}  // namespace
}  // namespace haarfield
