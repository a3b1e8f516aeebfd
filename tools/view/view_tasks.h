#pragma once
/// What takes its time beside the session: a bake for POV-Ray, and the reference picture.

#include "tools/scene_options.h"

#include <nlohmann/json_fwd.hpp>

#include <algorithm>
#include <map>
#include <mutex>
#include <thread>

namespace haarfield {

struct TaskSettings {
    RenderChoices render;          ///< Of a bake; for a reference see reference_bounces.
    std::filesystem::path output;  ///< A folder for each task goes below.
    int threads = 1;
};

/// How often light goes on in the reference of a session whose light does so often: POV-Ray's radiosity takes
/// many times as long for each bounce after the first, which is most of what there is.
inline int reference_bounces(int of_session) {
    return std::min(of_session, 1);
}

/// One task at a time, on a thread of its own. Files that it makes are known by name from then on.
class ViewTasks {
public:
    /// tell  is told, from the task's thread, of its progress and its end: messages of PROTOCOL.md.
    ViewTasks(TaskSettings settings, std::function<void(const nlohmann::json&)> tell);
    ~ViewTasks() { cancel(); }

    /// Runs a command of haarfield, `bake` or `reference`, on the scene.
    ///
    /// scene_text  of a scene file in `folder_of(command)`.
    /// errors      a task is running.
    Result<Done> start(const std::string& command, const std::string& scene_name, std::string scene_text);

    void cancel();  ///< Returns when the task has ended.

    /// Where a command's files go.
    std::filesystem::path folder_of(const std::string& command) const { return settings_.output / command; }

    /// Makes a file known; its name is that of the file.
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
