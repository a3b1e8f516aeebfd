#pragma once
/// A session: pages display a scene, and one of them edits it. The session's thread distributes messages and
/// decides what to compute next.

#include "tools/view/scene_editor.h"
#include "tools/view/session_pages.h"
#include "tools/view/view_job.h"
#include "tools/view/view_tasks.h"

#include <atomic>
#include <condition_variable>
#include <deque>
#include <thread>

namespace haarfield {

struct ViewSettings {
    RenderSettings render;  ///< The settings of `bake`.
    TransferSettings transfer;
    std::filesystem::path scene_file;
    std::string session;  ///< A word that identifies the session.
    TaskSettings tasks;
};

/// A session. A separate thread drives the scene; all functions return at once.
class ViewSession {
public:
    /// scene     its camera must have a place.
    /// entities  prepared from the scene.
    /// shelf     must outlive the session.
    ViewSession(const Scene& scene, SceneEntities entities, ViewSettings settings, LightShelf& shelf,
                Audience audience);
    ~ViewSession();  ///< Stops running work; returns within about 100 ms.

    void join(PageId page);   ///< Adds a page. It receives the whole state, and steers if no other page does.
    void leave(PageId page);  ///< Removes a page. If it steered, the next page takes over.

    /// Processes a text of a page. Invalid texts are answered with an error and change nothing.
    void receive(PageId page, std::string_view text);

    /// Informs the pages that the shelf has a new light.
    void lights_changed();

    const SceneEntities& entities() const { return live_.entities(); }

    /// Returns a file that tasks have written, by its name; none if there is no such file.
    std::optional<std::filesystem::path> made_file(std::string_view name) const {
        return tasks_.made_file(name);
    }

private:
    using Clock = std::chrono::steady_clock;

    struct Arrival {
        PageId page = 0;
        enum class What { message, joined, left, lights, task } what = What::message;
        std::optional<Message> message{};
        std::string text{};  ///< For `task`: the message to send.
        Clock::time_point time = Clock::now();
    };

    void run(const std::stop_token& stop);
    void post(Arrival arrival);
    void take_arrivals(std::deque<Arrival> arrivals);
    void take_message(const Arrival& arrival);
    Result<Done> take_content(PageId page, const Message& message);
    Result<Done> start_task(PageId page, TaskKind kind);
    void make_picture();

    ViewJob next_job() const;
    bool ends(const Arrival& arrival, const ViewJob& job) const;
    /// Runs work(), and turns exceptions into errors.
    Result<Done> guarded_work(const ViewJob& job, const Progress& progress);
    Result<Done> work(const ViewJob& job, const Progress& progress);
    /// True if the colours are those of the present design.
    bool is_shown(bool with_exposure = true) const;
    void tell_trouble(const Error& error);

    LightShelf& shelf_;
    LiveScene live_;
    SessionPages pages_;
    SceneEditor editor_;
    Preview preview_;
    ViewTasks tasks_;

    // Used by the session's thread alone.
    std::optional<Design> shown_;  ///< The design that the displayed colours belong to.
    Exactness exactness_ = Exactness::moving;
    std::optional<BakeError> error_;             ///< Of exact colours in the window, once it is measured.
    std::optional<std::uint64_t> failed_light_;  ///< Stamp of a light with which work has failed.
    Clock::time_point last_input_;
    std::vector<PageId> pictures_;  ///< Pages that wait for a picture, made when the colours are exact.

    // Shared by all threads.
    std::atomic<bool> has_specular_ = true;  ///< True if colours depend on the eye.
    mutable std::mutex mutex_;
    std::condition_variable_any woken_;
    std::deque<Arrival> arrivals_;
    ViewJob job_;                ///< The running job,
    std::stop_source stop_job_;  ///< and its stop source.
    Vec3f last_eye_;             ///< In the messages that have arrived.
    PageId steering_ = 0;        ///< The page whose messages end jobs.

    std::jthread thread_;  ///< Last, because it uses all other members.
};

}  // namespace haarfield
