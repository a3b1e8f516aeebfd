#include "bridge/povray/povray_process.h"

#include "fields/file/write_file.h"
#include "tests/fixtures/bridge_fixtures.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <thread>

namespace haarfield {
namespace {

constexpr const char* good_scene =
    "#version 3.7;\nglobal_settings { assumed_gamma 1 }\n"
    "camera { location <0, 0, 5> direction <0, 0, -1> right x up y }\n"
    "sphere { 0, 2 pigment { rgb <0.5, 0.25, 2> } finish { emission 1 ambient 0 diffuse 0 } }\n";

PovrayOptions small() {
    PovrayOptions options;
    options.width = options.height = 16;
    return options;
}

TEST(PovrayProcess, RendersWithCoverageAndReportsProgress) {
    const TestFolder folder;
    ASSERT_TRUE(write_file(folder / "a b's.pov", good_scene));
    PovrayOptions options = small();
    options.antialiasing = 2;
    options.threads = 1;
    std::uint64_t done = 0, total = 0;
    Progress progress;
    progress.report = [&](std::string_view, std::uint64_t d, std::uint64_t t) { done = d, total = t; };
    const Result<PovrayRun> run =
        run_povray(folder / "a b's.pov", folder / "out dir/c d.exr", options, progress);
    ASSERT_TRUE(run) << run.error().message();
    EXPECT_EQ(done, 256u);
    EXPECT_EQ(total, 256u);
    EXPECT_NE(run->command_line.find("+W16 +H16"), std::string::npos) << run->command_line;
    const Result<Image> image = read_image(folder / "out dir/c d.exr");
    ASSERT_TRUE(image) << image.error().message();
    EXPECT_EQ(image->pixels[16 * 8 + 8], Rgb(0.5f, 0.25f, 2));
    EXPECT_EQ(image->coverage[16 * 8 + 8], 1.0f);
    EXPECT_EQ(image->coverage[0], 0.0f);
    int partial = 0;
    for (std::size_t i = 0; i < 256; ++i) {
        EXPECT_NEAR(image->pixels[i].z, 2 * image->coverage[i], 2e-3) << "radiance is premultiplied";
        partial += image->coverage[i] > 0 && image->coverage[i] < 1;
    }
    EXPECT_GT(partial, 8);
    EXPECT_EQ(folder.files(), (std::vector<std::string>{"a b's.pov", "out dir", "out dir/c d.exr"}));
}

TEST(PovrayProcess, FollowsALinkToThePicture) {
    const TestFolder folder;
    ASSERT_TRUE(write_file(folder / "scene.pov", good_scene));
    std::filesystem::create_directory(folder / "elsewhere");
    std::filesystem::create_symlink("elsewhere/picture.exr", folder / "link.exr");
    const Result<PovrayRun> run = run_povray(folder / "scene.pov", folder / "link.exr", small());
    ASSERT_TRUE(run) << run.error().message();
    EXPECT_TRUE(std::filesystem::is_symlink(folder / "link.exr"));
    EXPECT_TRUE(read_image(folder / "elsewhere/picture.exr"));
    EXPECT_FALSE(run_povray(folder / "scene.pov", folder / "elsewhere", small())) << "a directory";
}

TEST(PovrayProcess, ReportsPovraysMessages) {
    const TestFolder folder;
    ASSERT_TRUE(write_file(
        folder / "bad.pov",
        "#version 3.7;\nglobal_settings { assumed_gamma 1 }\n"
        "sphere { 0, 1 pigment { rgb a_name_so_long_that_povray_breaks_its_line_before_the_end } }\n"));
    const Result<PovrayRun> run = run_povray(folder / "bad.pov", folder / "bad.exr", small());
    ASSERT_FALSE(run);
    EXPECT_NE(run.error().what.find(
                  "File 'bad.pov' line 3: Parse Error: Expected 'numeric expression', undeclared identifier "
                  "'a_name_so_long_that_povray_breaks_its_line_before_the_end' found instead"),
              std::string::npos)
        << run.error().message();
    EXPECT_EQ(folder.files(), (std::vector<std::string>{"bad.pov"}));
}

TEST(PovrayProcess, ReportsAMissingPovrayOrScene) {
    const TestFolder folder;
    ASSERT_TRUE(write_file(folder / "a.pov", good_scene));
    PovrayOptions options = small();
    options.program = "/nonexistent/povray";
    const Result<PovrayRun> run = run_povray(folder / "a.pov", folder / "a.exr", options);
    ASSERT_FALSE(run);
    EXPECT_EQ(run.error().where, "/nonexistent/povray");
    EXPECT_NE(run.error().what.find("No such file"), std::string::npos) << run.error().message();
    EXPECT_FALSE(run_povray(folder / "b.pov", folder / "a.exr", small()));
    options.program = "true";  // succeeds, but draws nothing
    const Result<PovrayRun> silent = run_povray(folder / "a.pov", folder / "a.exr", options);
    ASSERT_FALSE(silent);
    EXPECT_NE(silent.error().what.find("no picture"), std::string::npos) << silent.error().message();
    EXPECT_EQ(folder.files(), (std::vector<std::string>{"a.pov"}));
}

TEST(PovrayProcess, StopsWhenAskedAndLeavesNothing) {
    const TestFolder folder;
    // Endless parsing.
    ASSERT_TRUE(write_file(folder / "endless.pov",
                           "#version 3.7;\n#declare A = 1;\n#while (A > 0) #declare A = 1; #end\n"));
    std::stop_source stop;
    std::jthread later([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(300));
        stop.request_stop();
    });
    Progress progress;
    progress.stop = stop.get_token();
    const Result<PovrayRun> run = run_povray(folder / "endless.pov", folder / "a.exr", small(), progress);
    ASSERT_FALSE(run);
    EXPECT_EQ(run.error().code, ErrorCode::interrupted);
    EXPECT_EQ(folder.files(), (std::vector<std::string>{"endless.pov"}));
}

/// Returns a program that runs `body` instead of POV-Ray.
std::filesystem::path impostor(const TestFolder& folder, const std::string& body) {
    write_text(folder / "impostor", "#!/bin/sh\n" + body + "\n");
    std::filesystem::permissions(folder / "impostor", std::filesystem::perms::owner_all);
    return folder / "impostor";
}

TEST(PovrayProcess, APovrayThatHangsOrDiesIsAnErrorAndLeavesNothing) {
    const TestFolder folder;
    ASSERT_TRUE(write_file(folder / "a.pov", good_scene));
    PovrayOptions options = small();
    options.patience = 0.2;
    for (const auto& [body, words] :
         {std::pair{"echo Parse Error: late >&2; exec sleep 60", "reported nothing for 0.2 s"},
          {"exec 2>&-; kill -SEGV $$", "ended by signal 11"},
          {"exit 3", "failed (exit code 3)"}}) {
        options.program = impostor(folder, body);
        const Result<PovrayRun> run = run_povray(folder / "a.pov", folder / "out/a.exr", options);
        ASSERT_FALSE(run) << body;
        EXPECT_NE(run.error().what.find(words), std::string::npos) << run.error().message();
        EXPECT_EQ(folder.files(), (std::vector<std::string>{"a.pov", "impostor", "out"}));
    }
}

TEST(PovrayProcess, EndsWithItsParentProcess) {
    const TestFolder folder;
    ASSERT_TRUE(write_file(folder / "a.pov", good_scene));
    PovrayOptions options = small();
    options.program = impostor(folder, "echo $$ > number; mv number id; exec sleep 60");
    const pid_t runner = fork();
    if (runner == 0) {
        (void)run_povray(folder / "a.pov", folder / "out/a.exr", options);
        _exit(0);
    }
    for (int i = 0; i < 1000 && !std::filesystem::exists(folder / "id"); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    const pid_t id = std::stoi(text_of(folder / "id"));
    EXPECT_EQ(kill(id, 0), 0);
    kill(runner, SIGKILL);
    waitpid(runner, nullptr, 0);
    bool has_ended = false;
    for (int i = 0; i < 1000 && !has_ended; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
        // A zombie process has ended, too.
        const std::string status = text_of("/proc/" + std::to_string(id) + "/stat");
        has_ended = status.empty() || status.find(") Z ") != std::string::npos;
    }
    EXPECT_TRUE(has_ended);
}

TEST(PovrayProcess, FilesOfKilledProcessesAreRemovedAndFilesInUseAreNot) {
    const TestFolder folder;
    ASSERT_TRUE(write_file(folder / "a.pov", good_scene));
    std::filesystem::create_directories(folder / ".povray-killed/below");
    std::filesystem::create_directories(folder / ".povray-in-use");
    const auto long_ago = std::filesystem::file_time_type::clock::now() - std::chrono::hours(1);
    for (const char* name : {".povray-killed", ".povray-in-use"})
        std::filesystem::last_write_time(folder / name, long_ago);
    const int lock = open((folder / ".povray-in-use").c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    ASSERT_EQ(flock(lock, LOCK_EX), 0);
    EXPECT_TRUE(run_povray(folder / "a.pov", folder / "a.exr", small()));
    EXPECT_EQ(folder.files(), (std::vector<std::string>{".povray-in-use", "a.exr", "a.pov"}));
    close(lock);
}

TEST(PovrayProcess, ReportsPovraysWarnings) {
    const TestFolder folder;
    ASSERT_TRUE(write_file(folder / "a.pov", std::string(good_scene) + "#warning \"mind the gap\\n\"\n"));
    const Result<PovrayRun> run = run_povray(folder / "a.pov", folder / "a.exr", small());
    ASSERT_TRUE(run) << run.error().message();
    ASSERT_EQ(run->warnings.size(), 1u);
    EXPECT_NE(run->warnings[0].find("mind the gap"), std::string::npos);
}

}  // namespace
}  // namespace haarfield
