#include <gtest/gtest.h>
#include <sys/wait.h>

#include <fmt/format.h>
#include <cstdlib>
#include <map>

#include "fields/base/sanitizers.h"
#include "scenes/image.h"
#include "tests/fixtures/test_folder.h"

namespace haarfield {
namespace {

constexpr const char* box =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nf 4 3 2 1\nf 5 6 7 8\n"
    "f 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 4 1 5 8\n";

/// Returns a scene of one entity that bakes in a moment. The names are TOML strings.
std::string scene_of(const std::string& mesh, const std::string& entity, const std::string& instance) {
    return fmt::format(
        "[entities.{1}]\nmesh = {0}\nfine_vertices = 40\nplanar_samples = 20\nspherical_samples = 20\n"
        "[environment]\nsky = {{ turbidity = 3, sun_elevation = 40 }}\n"
        "[[instances]]\nentity = {1}\nname = {2}\n[[instances]]\nentity = {1}\ntranslate = [2, 0, 0]\n"
        "[camera]\nposition = [3, 2, 3]\ntarget = [0, 0.5, 0]\nresolution = [16, 12]\n",
        mesh, entity, instance);
}

/// Runs the program from a shell in a temporary folder.
class HostileSurroundings : public testing::Test {
protected:
    void SetUp() override {
        std::filesystem::create_directory(folder / "in");
        write_text(folder / "in/box.obj", box);
        write_text(folder / "in/s.toml", scene_of("\"box.obj\"", "\"box\"", "\"one\""));
    }

    /// Runs a shell command in the folder `in`, with the program as `$H`. Returns the exit code; messages()
    /// returns its output.
    int run(const std::string& line) {
        const std::string command = fmt::format("cd '{}/in' && exec 2> ../said && H='{}' && {{ {}\n}}",
                                                folder.path().string(), HAARFIELD_PROGRAM, line);
        const int status = std::system(command.c_str());
        return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    }
    std::string messages() const { return text_of(folder / "said"); }

    /// Returns the content of all files of an output folder, by name.
    std::map<std::string, std::string> content(const std::string& name) const {
        std::map<std::string, std::string> files;
        for (const auto& entry : std::filesystem::recursive_directory_iterator(folder / name))
            if (entry.is_regular_file())
                files[std::filesystem::relative(entry.path(), folder / name).string()] =
                    text_of(entry.path());
        return files;
    }

    TestFolder folder;
};

TEST_F(HostileSurroundings, UntrustedFilesAreRefusedWithoutASandboxUnlessAllowed) {
    if (is_thread_sanitized) GTEST_SKIP() << "ThreadSanitizer does not support reader processes";
    EXPECT_EQ(run("HAARFIELD_READER= $H info box.obj"), 1);
    EXPECT_NE(messages().find("--unsandboxed"), std::string::npos) << messages();
    EXPECT_EQ(run("HAARFIELD_READER= $H info --unsandboxed box.obj > /dev/null"), 0) << messages();
    EXPECT_EQ(run("$H info box.obj > /dev/null"), 0) << messages();
}

TEST_F(HostileSurroundings, AnotherReaderProcessReadsImages) {
    if (is_thread_sanitized) GTEST_SKIP() << "ThreadSanitizer does not support reader processes";
    Image image{2, 2, std::vector<Rgb>(4, Rgb(1, 2, 3)), {}};
    ASSERT_TRUE(write_image(image, folder / "in/a.exr"));
    EXPECT_EQ(run("$H compare a.exr a.exr -o d > /dev/null"), 0) << messages();
    std::filesystem::create_directory(folder / "alone");
    EXPECT_EQ(run("cp ${H%/*}/haarfield-reader ../alone"), 0) << messages();
    EXPECT_EQ(run("HAARFIELD_READER=../alone/haarfield-reader $H info box.obj > /dev/null"), 0) << messages();
    EXPECT_EQ(run("HAARFIELD_READER=../alone/haarfield-reader $H compare a.exr a.exr -o d"), 1);
    EXPECT_NE(messages().find("a.exr: no process could be started to read it"), std::string::npos)
        << messages();
}

TEST_F(HostileSurroundings, NamesAreNeverPovrayStatementsOrPathsElsewhere) {
    const std::string evil = "a\"b'{}$(touch sneaked)`touch sneaked` \xc3\xa9 #declare x=1; sphere{0,9}";
    write_text(folder / ("in/" + evil + ".obj"), "mtllib " + evil + ".mtl\no ../../x\nusemtl " + evil + "\n" +
                                                     box + "usemtl ../up\nf 1 2 3\n" + "usemtl " +
                                                     std::string(3000, 'm') + "\nf 2 3 4\n");
    write_text(folder / ("in/" + evil + ".mtl"), "newmtl " + evil + "\nKd 1 0 0\nnewmtl ../up\nKd 0 1 0\n");
    std::string quoted;
    for (const char c : evil + ".obj") quoted += c == '"' ? std::string("\\\"") : std::string(1, c);
    const std::string scene =
        scene_of("\"" + quoted + "\"", "'e\"} sphere{0,9}'", "'#declare Y=2; {$HOME} \"'");
    const std::string long_name(240, 's');
    for (const std::string& name : {evil, std::string("new\nline"), long_name, long_name + "2"}) {
        write_text(folder / "in/scene.toml", scene);
        std::filesystem::rename(folder / "in/scene.toml", folder / ("in/" + name + ".toml"));
    }
    EXPECT_EQ(
        run("for s in *.toml; do case \"$s\" in s.toml) ;; a*) $H bake \"$s\" -o '../o\"ut {}' || exit 9 ;;\n"
            "*) $H bake \"$s\" -o '../o\"ut {}' --no-render || exit 9 ;; esac; done"),
        0)
        << messages();
    const auto files = content("o\"ut {}");
    EXPECT_TRUE(files.contains("baked.png"));
    std::size_t scenes = 0;
    for (const auto& [name, text] : files) {
        scenes += name.ends_with(".pov");
        EXPECT_LE(name.size(), 200u);
        if (!name.ends_with(".pov") && !name.ends_with(".inc")) continue;
        EXPECT_EQ(text.find("sphere{"), std::string::npos) << name;
        EXPECT_EQ(text.find("sphere {0,9"), std::string::npos) << name;
        EXPECT_EQ(text.find("#declare Y"), std::string::npos) << name;
    }
    EXPECT_EQ(scenes, 4u);
    EXPECT_FALSE(std::filesystem::exists(folder / "in/sneaked"));
    // Names that would be paths are rejected.
    for (const char* name : {"../up", "a/b", ".hidden", "two\\\\n\\nlines"}) {
        write_text(folder / "in/t.toml", scene_of("\"box.obj\"", fmt::format("\"{}\"", name), "\"one\""));
        EXPECT_EQ(run("$H bake t.toml -o ../t --no-render"), 1) << name;
    }
}

TEST_F(HostileSurroundings, ClosedStreamsFewFilesAndOtherLocalesChangeNothing) {
    ASSERT_EQ(run("$H bake s.toml -o ../a --no-render"), 0) << messages();
    EXPECT_EQ(run("$H bake s.toml -o ../b --no-render <&- >&- 2>&-"), 0) << messages();
    EXPECT_EQ(run("ulimit -n 32; LC_ALL=de_DE.UTF-8 $H bake s.toml -o ../c --no-render --threads 3"), 0)
        << messages();
    EXPECT_EQ(content("a"), content("b"));
    EXPECT_EQ(content("a"), content("c"));
    // The reader of the pipe has closed it: written files are complete, and the exit code reports the lost
    // output.
    EXPECT_EQ(run("{ $H bake s.toml -o ../d --no-render; echo $? > ../code; } | true"), 0);
    const std::string code = text_of(folder / "code");
    EXPECT_TRUE(code == "0\n" || code == "1\n") << code;
    for (const auto& [name, text] : content("d")) EXPECT_FALSE(name.ends_with(".tmp")) << name;
    EXPECT_EQ(run("$H info box.obj > /dev/full"), 1);
}

/// If its stdout and stderr fail, the program keeps its exit code for bad input, and has one for lost
/// results.
TEST_F(HostileSurroundings, MessagesThatCannotBePrintedNeverAbort) {
    const auto code_of = [&](const std::string& command, const std::string& streams) {
        EXPECT_EQ(run("rm -f ../code; { " + command + "; echo $? > ../code; } " + streams), 0);
        return text_of(folder / "code");
    };
    for (const char* streams : {"2>&1 | true", "2>/dev/full >/dev/full", "2>&- >&-", "2>/dev/full | true"}) {
        EXPECT_EQ(code_of("sleep 0.2; $H info nothing", streams), "1\n") << streams;
        EXPECT_EQ(code_of("sleep 0.2; $H bake", streams), "2\n") << streams;
        EXPECT_EQ(code_of("sleep 0.2; $H bake s.toml -o ../lost --no-render --exposure 9", streams),
                  std::string(streams) == "2>&- >&-" ? "0\n" : "1\n")
            << streams;
        EXPECT_TRUE(content("lost").contains("s.pov")) << streams << ": the bake ended early";
        std::filesystem::remove_all(folder / "lost");
    }
}

TEST_F(HostileSurroundings, ReportsGoToStreamsAndThroughLinks) {
    EXPECT_EQ(run("$H info box.obj --quiet --report /dev/stdout | grep -q '\"command\"'"), 0) << messages();
    EXPECT_EQ(run("mkfifo ../pipe; cat ../pipe > ../read & $H info box.obj --report ../pipe; wait"), 0);
    EXPECT_NE(text_of(folder / "read").find("\"command\""), std::string::npos);
    EXPECT_TRUE(std::filesystem::is_fifo(folder / "pipe"));
    // Text printed before the report is preserved.
    EXPECT_EQ(run("$H info box.obj --report /dev/stdout > ../both"), 0);
    EXPECT_NE(text_of(folder / "both").find("\"command\""), std::string::npos);
    EXPECT_NE(text_of(folder / "both").find("box.obj"), std::string::npos);
    EXPECT_NE(text_of(folder / "both").front(), '{');
    EXPECT_EQ(run("ln -s ../report.json link.json; $H info box.obj --report link.json"), 0);
    EXPECT_TRUE(std::filesystem::is_symlink(folder / "in/link.json"));
    EXPECT_TRUE(std::filesystem::is_regular_file(folder / "report.json"));
    EXPECT_EQ(run("$H info box.obj --report ."), 1);
    EXPECT_NE(messages().find("is a directory"), std::string::npos) << messages();
}

TEST_F(HostileSurroundings, AFullDiskIsAnErrorAndLeavesNoHalfFile) {
    EXPECT_EQ(run("ulimit -f 8; $H bake s.toml -o ../full --no-render"), 1);
    EXPECT_NE(messages().find("File too large"), std::string::npos) << messages();
    EXPECT_TRUE(content("full").empty());
    // A folder that cannot be created.
    EXPECT_EQ(run("$H bake s.toml -o /dev/null/out --no-render"), 1);
    EXPECT_EQ(run("$H bake s.toml -o /proc/out --no-render"), 1);
}

TEST_F(HostileSurroundings, LittleMemoryIsAnErrorOrEnough) {
    if (has_shadow_memory) GTEST_SKIP() << "sanitizers reserve more address space";
    for (const int kilobytes : {600000, 700000, 800000, 1200000}) {
        const int code = run(fmt::format("ulimit -v {}; $H bake s.toml -o ../m --no-render", kilobytes));
        // 127: not enough memory for the loader of libraries
        EXPECT_TRUE(code == 0 || code == 1 || code == 127) << kilobytes << ": " << code << "\n" << messages();
    }
}

TEST_F(HostileSurroundings, WithoutPovrayTheBakeIsWrittenAndTheErrorNamesPovray) {
    EXPECT_EQ(run("PATH=/nonexistent; $H bake s.toml -o ../out"), 1);
    EXPECT_NE(messages().find("expected POV-Ray 3.7"), std::string::npos) << messages();
    EXPECT_TRUE(content("out").contains("s.pov"));
    write_text(folder / "povray", "#!/bin/sh\nexec sleep 100\n");
    std::filesystem::permissions(folder / "povray", std::filesystem::perms::owner_all);
    EXPECT_EQ(run("PATH=..:$PATH; $H bake s.toml -o ../out --povray-patience 0.5"), 1);
    EXPECT_NE(messages().find("reported nothing for 0.5 s"), std::string::npos) << messages();
}

TEST_F(HostileSurroundings, EightProcessesInOneFolderLeaveTheFilesOfOne) {
    ASSERT_EQ(run("$H bake s.toml -o ../one --no-render"), 0) << messages();
    EXPECT_EQ(run("for i in 1 2 3 4 5 6 7 8; do $H bake s.toml -o ../eight --no-render & p=\"$p $!\"; done\n"
                  "for i in $p; do wait $i || exit 1; done"),
              0)
        << messages();
    EXPECT_EQ(content("one"), content("eight"));
}

TEST_F(HostileSurroundings, ThreadsChangeNoByteOfWhatIsWritten) {
    for (const int threads : {1, 2, 3, 8})
        ASSERT_EQ(run(fmt::format("$H bake s.toml -o ../t{0} --no-render --threads {0}", threads)), 0)
            << messages();
    for (const char* other : {"t2", "t3", "t8"}) EXPECT_EQ(content("t1"), content(other)) << other;
}

TEST_F(HostileSurroundings, AFileThatCrashesItsReaderIsAnErrorWithItsName) {
    // A valid GLB chunk, with JSON nested so deeply that a recursive parser's stack overflows.
    std::string json(4000000, '[');
    const auto number = [](std::size_t value) {
        const auto word = static_cast<std::uint32_t>(value);
        return std::string(reinterpret_cast<const char*>(&word), 4);
    };
    write_text(folder / "in/deep.glb",
               "glTF" + number(2) + number(20 + json.size()) + number(json.size()) + "JSON" + json);
    EXPECT_EQ(run("$H info deep.glb"), 1);
    EXPECT_NE(messages().find("deep.glb"), std::string::npos) << messages();
}

}  // namespace
}  // namespace haarfield
