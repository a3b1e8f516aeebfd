#pragma once
/// Long tasks of a session: a bake for POV-Ray, and the reference picture.

#include "tools/scene_options.h"

#include <nlohmann/json_fwd.hpp>

#include <algorithm>
#include <map>
#include <mutex>
#include <thread>

namespace haarfield {

struct TaskSettings {
    RenderChoices render;          ///< Of a bake; for a reference see reference_bounces.
    std::filesystem::path output;  ///< The parent of each task's folder.
    int threads = 1;
};

/// Returns the number of bounces of a session's reference: at most one. Each further bounce makes POV-Ray's
/// radiosity many times slower, and the first contributes most of the indirect light.
inline int reference_bounces(int of_session) {
    return std::min(of_session, 1);
}

/// Runs one task at a time on a separate thread. The written files remain known by name.
class ViewTasks {
public:
    /// tell  called from the task's thread with messages of PROTOCOL.md about its progress and its end.
    ViewTasks(TaskSettings settings, std::function<void(const nlohmann::json&)> tell);
    ~ViewTasks() { cancel(); }

    /// Runs a command of haarfield, `bake` or `reference`, on the scene.
    ///
    /// scene_text  the text of a scene file in `folder_of(command)`.
    /// errors      another task is running.
    Result<Done> start(const std::string& command, const std::string& scene_name, std::string scene_text);

    void cancel();  ///< Returns when the task has ended.

    /// Returns the folder of a command's files.
    std::filesystem::path folder_of(const std::string& command) const { return settings_.output / command; }

    /// Makes a file known. Returns its name.
    std::string add_file(const std::filesystem::path& file);
    std::optional<std::filesystem::path> made_file(std::string_view name) const;

private:
    void run(const std::string& command, const std::filesystem::path& scene, const std::stop_token& stop);

    TaskSettings settings_;
    std::function<void(const nlohmann::json&)> tell_;
    mutable std::mutex mutex_;
    std::map<std::string, std::filesystem::path, std::less<>> files_;
    bool running_ = false;
    std::jthread thread_;
};

}  // namespace haarfield
