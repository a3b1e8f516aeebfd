#pragma once
/// Runs the program in a folder with a small scene, as users of plans do.

#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/fixtures/test_folder.h"

extern char** environ;

namespace haarfield {

class FarmTest : public testing::Test {
protected:
    struct Outcome {
        int code = -1;  ///< Exit code; -signal if killed by a signal.
        std::string out, err;
    };

    pid_t start(std::vector<std::string> arguments) {
        const std::string said = fmt::format("said_{}", ++started_);
        arguments.insert(arguments.begin(), HAARFIELD_PROGRAM);
        std::vector<char*> pointers;
        for (std::string& argument : arguments) pointers.push_back(argument.data());
        pointers.push_back(nullptr);
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        posix_spawn_file_actions_addchdir_np(&actions, folder.path().c_str());
        constexpr int flags = O_WRONLY | O_CREAT | O_TRUNC;
        posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, (said + ".out").c_str(), flags, 0600);
        posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, (said + ".err").c_str(), flags, 0600);
        pid_t child = -1;
        const int failure =
            posix_spawn(&child, HAARFIELD_PROGRAM, &actions, nullptr, pointers.data(), environ);
        posix_spawn_file_actions_destroy(&actions);
        // An invalid process number must not be returned: a signal to -1 would reach all processes.
        if (failure != 0 || child <= 0) throw std::runtime_error(HAARFIELD_PROGRAM " cannot be run");
        said_[child] = said;
        return child;
    }

    Outcome finish(pid_t child) {
        int status = 0;
        waitpid(child, &status, 0);
        const std::string said = said_[child];
        return {WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status),
                text_of(folder / (said + ".out")), text_of(folder / (said + ".err"))};
    }

    Outcome run(std::vector<std::string> arguments) { return finish(start(std::move(arguments))); }

    void expect_done(std::vector<std::string> arguments) {
        const Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.code, 0) << arguments[0] << " " << arguments.back() << ": " << outcome.err;
    }

    Outcome work(const std::string& plan, std::size_t task) {
        return run({"work", plan, "--task", std::to_string(task)});
    }

    /// Runs several tasks in one process.
    void expect_worked(const std::string& plan, const std::string& tasks) {
        expect_done({"work", plan, "--tasks", tasks});
    }
    void expect_all_worked(const std::string& plan) {
        expect_worked(plan, fmt::format("0-{}", task_count(plan) - 1));
    }

    /// Runs a shell command in the folder.
    Outcome shell(const std::string& line) {
        const int status = std::system(
            fmt::format("cd '{}' && {{ {}\n}} > shell.out 2> shell.err", folder.path().string(), line)
                .c_str());
        return {WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status), text_of(folder / "shell.out"),
                text_of(folder / "shell.err")};
    }

    nlohmann::json status(const std::string& plan) {
        const Outcome said = run({"status", plan, "--json"});
        EXPECT_EQ(said.code, 0) << said.err;
        return said.code == 0 ? nlohmann::json::parse(said.out, nullptr, false) : nlohmann::json::object();
    }

    std::size_t task_count(const std::string& plan) { return status(plan).value("tasks", std::size_t(0)); }

    /// Writes `name`.toml: two boxes on a floor under a low sun.
    void write_scene(const std::string& name = "room", int fine_vertices = 200, float height = 1) {
        write_text(folder / (name + ".obj"),
                   fmt::format("v -0.5 0 -0.5\nv 0.5 0 -0.5\nv 0.5 0 0.5\nv -0.5 0 0.5\n"
                               "v -0.5 {0} -0.5\nv 0.5 {0} -0.5\nv 0.5 {0} 0.5\nv -0.5 {0} 0.5\n"
                               "f 1 2 3 4\nf 8 7 6 5\nf 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 4 8 5 1\n",
                               height));
        write_text(folder / "floor.obj", "v -3 0 -3\nv 3 0 -3\nv 3 0 3\nv -3 0 3\nf 4 3 2 1\n");
        write_text(folder / (name + ".toml"), fmt::format(R"(
[camera]
position = [2.5, 2, 3]
target = [0, 0.4, 0]
vertical_fov = 40
resolution = [48, 40]
[environment]
sky = {{ turbidity = 6, sun_elevation = 50, sun_azimuth = 20, sun_angular_radius = 5 }}
[materials.clay]
diffuse = [0.6, 0.5, 0.4]
specular = [0.2, 0.2, 0.2]
shininess = 30
convention = "povray"
[entities.box]
mesh = "{0}.obj"
material = "clay"
fine_vertices = {1}
coarse_triangles = 0
planar_samples = 100
spherical_samples = 100
[entities.floor]
mesh = "floor.obj"
material = "clay"
fine_vertices = 300
planar_samples = 20
spherical_samples = 20
coarse_triangles = 0
[[instances]]
entity = "floor"
[[instances]]
entity = "box"
translate = [0, 0.001, 0]
[[instances]]
entity = "box"
translate = [1.4, 0.001, -0.3]
rotate = [0, 30, 0]
)",
                                                          name, fine_vertices));
    }

    /// Returns the files below a folder, by name.
    std::map<std::string, std::string> files_below(const std::string& name) {
        std::map<std::string, std::string> files;
        std::error_code none;
        for (const auto& entry : std::filesystem::recursive_directory_iterator(folder / name, none))
            if (entry.is_regular_file())
                files[entry.path().lexically_relative(folder / name).string()] = text_of(entry.path());
        return files;
    }

    void expect_same_files(const std::string& found, const std::string& wanted) {
        const auto a = files_below(found), b = files_below(wanted);
        EXPECT_FALSE(b.empty()) << wanted;
        std::set<std::string> names;
        for (const auto* files : {&a, &b})
            for (const auto& [name, bytes] : *files) names.insert(name);
        for (const std::string& name : names) {
            EXPECT_TRUE(a.contains(name)) << found << " lacks " << name;
            EXPECT_TRUE(b.contains(name)) << wanted << " lacks " << name;
            if (a.contains(name) && b.contains(name)) {
                EXPECT_TRUE(a.at(name) == b.at(name)) << name << " differs";
            }
        }
    }

    const TestFolder folder;

private:
    int started_ = 0;
    std::map<pid_t, std::string> said_;
};

}  // namespace haarfield
