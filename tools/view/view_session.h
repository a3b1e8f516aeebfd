#pragma once
/// A scene that pages look at and one of them changes: takes messages, decides what is to be computed next,
/// and says what came out of it.

#include "tools/view/light_shelf.h"
#include "tools/view/messages.h"
#include "tools/view/scene_assets.h"
#include "tools/view/scene_file.h"
#include "tools/view/view_job.h"
#include "tools/view/view_tasks.h"

#include <atomic>
#include <condition_variable>
#include <deque>
#include <thread>

namespace haarfield {

using PageId = std::uint64_t;

/// Bytes that several pages are sent.
using SharedBytes = std::shared_ptr<const std::string>;

/// The way to the pages. Called from the session's threads, never after the session's end.
struct Audience {
    std::function<void(PageId, const std::string& text)> tell;
    std::function<void(const std::string& text)> tell_all;
    std::function<void(SharedBytes frame)> show_all;  ///< A frame that has not been sent yet gives way.
    std::function<void(PageId, SharedBytes frame)> show;
    std::function<void(PageId)> shown;  ///< The page has room for another frame.
};

struct ViewSettings {
    RenderSettings render;  ///< As `bake` has it.
    TransferSettings transfer;
    std::filesystem::path scene_file;
    std::string session;  ///< A word that tells it apart from others.
    TaskSettings tasks;
};

/// One session. A thread of its own drives the scene; all calls return at once.
class ViewSession {
public:
    /// scene     its camera's place is known.
    /// entities  prepared from it.
    /// shelf     must outlive the session.
    ViewSession(const Scene& scene, SceneEntities entities, ViewSettings settings, LightShelf& shelf,
                Audience audience);
    ~ViewSession();  ///< Stops what is running; returns within some 100 ms.

    void join(PageId page);   ///< A page is there: it is told all, and steers if no other does.
    void leave(PageId page);  ///< If it steered, the next takes over.

    /// A page's text. Broken ones are answered with an error, and change nothing.
    void receive(PageId page, std::string_view text);

    /// A light came onto the shelf: pages are told.
    void lights_changed();

    const SceneEntities& entities() const { return live_.entities(); }

    /// A file that tasks have made, by its name; none if there is no such file.
    std::optional<std::filesystem::path> made_file(std::string_view name) const {
        return tasks_.made_file(name);
    }

private:
    using Clock = std::chrono::steady_clock;

    struct Arrival {
        PageId page;
        enum class What { message, joined, left, lights, task } what = What::message;
        std::optional<Message> message;
        std::string text;  ///< Of a task, what to tell.
        Clock::time_point time;
    };

    void run(const std::stop_token& stop);
    void post(Arrival arrival);
    void take_arrivals(std::deque<Arrival> arrivals);
    void take_message(const Arrival& arrival);
    Result<Done> take_content(PageId page, const Message& message);
    Result<Done> make_edit(const Edit& edit, const Message& message, const Variation& hand);
    Result<Done> take_lights(const NamedLights& lights, const Message& message);
    Result<Done> take_place(const PartialPlace& place, const Message& message);
    Result<Done> own_part(const OwnPart& part, const Message& message);
    Result<Done> take_look(const Look& look, const Message& message);
    void look_as_designed();
    Result<Done> save(PageId page, const Save& save, const Message& message);
    Result<Done> start_task(PageId page, const StartTask& task, const Message& message);
    Result<Done> restore(const Message& message);
    void decide_left_scene();
    void autosave();
    void tell_left_scene(PageId page) const;
    void make_picture();
    void steer(PageId page);

    ViewJob next_job() const;
    bool ends(const Arrival& arrival, const ViewJob& job) const;
    void take_highlights();
    /// As work; an exception is an error.
    Result<Done> guarded_work(const ViewJob& job, const Progress& progress);
    Result<Done> work(const ViewJob& job, const Progress& progress);
    void show_colours(Exactness exactness);
    /// True if the colours are those of the present design.
    bool is_shown(bool with_exposure = true) const;
    void tell_trouble(const Error& error);
    void tell_rest();

    void tell_scene(PageId page) const;
    void tell_state();
    void tell_work(const char* doing, std::string_view stage, double share);
    nlohmann::json state(bool all) const;

    ViewSettings settings_;
    LightShelf& shelf_;
    Audience audience_;
    LiveScene live_;
    History history_;
    Preview preview_;
    ViewTasks tasks_;
    SceneFile file_;
    Scene saved_;      ///< The scene as its file, or the file that was saved last, has it.
    Scene autosaved_;  ///< As the autosave file has it; `saved_` if there is none.
    bool autosave_has_failed_ = false;
    std::optional<Scene> left_;  ///< What an earlier session has left unsaved, until a page decides.

    // Of the session's thread.
    std::vector<PageId> pages_;                  ///< The first one steers.
    Camera window_;                              ///< What the steering page shows.
    Variation hand_;                             ///< What the last gesture varies.
    Variation likely_{Variation::Of::light, 0};  ///< What the next one is likely to.
    std::optional<Design> shown_;                ///< Of the colours, and how exact these are.
    Exactness exactness_ = Exactness::moving;
    std::optional<Design> told_;  ///< What pages know.
    bool told_undo_ = false, told_redo_ = false;
    bool has_stepped_ = false;  ///< The design's camera is none that the steering page has sent last.
    std::optional<std::uint64_t> failed_light_;  ///< Stamp of one with which work has failed.
    std::uint32_t frame_ = 0, last_message_ = 0;
    MessageHead last_head_;  ///< Of the last message that was applied, for errors of the work that it causes.
    Clock::time_point message_time_, last_input_;
    SharedBytes last_frame_;
    std::pair<std::uint32_t, std::uint32_t> told_rest_;  ///< Message and frame.
    std::vector<std::pair<PageId, bool>> pictures_;      ///< Asked for; once the colours are exact.

    // Shared.
    std::atomic<bool> has_highlights_ = true;  ///< Whether colours depend on the eye.
    mutable std::mutex mutex_;
    std::condition_variable_any woken_;
    std::deque<Arrival> arrivals_;
    ViewJob job_;                ///< That is running,
    std::stop_source stop_job_;  ///< and how to end it.
    Clock::time_point told_work_;
    Vec3f last_eye_;       ///< Of those that arrived.
    PageId steering_ = 0;  ///< Whose messages end jobs: the first of pages_.

    std::jthread thread_;  ///< The last: it uses all of the above.
};

}  // namespace haarfield
