#pragma once
/// A session: pages display a scene, and one of them edits it. The session processes messages, decides what
/// to compute next, and reports the results.

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

/// Bytes that are sent to several pages.
using SharedBytes = std::shared_ptr<const std::string>;

/// The connection to the pages. Called from the session's threads, never after the session's end.
struct Audience {
    std::function<void(PageId, const std::string& text)> tell;
    std::function<void(const std::string& text)> tell_all;
    std::function<void(SharedBytes frame)> show_all;  ///< Replaces a frame that has not been sent yet.
    std::function<void(PageId, SharedBytes frame)> show;
    std::function<void(PageId)> shown;  ///< The page can receive another frame.
};

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
        PageId page;
        enum class What { message, joined, left, lights, task } what = What::message;
        std::optional<Message> message;
        std::string text;  ///< For `task`: the message to send.
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
    Result<Done> own_part(const EditPartMaterial& part, const Message& message);
    Result<Done> take_look(const SetView& look, const Message& message);
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
    void take_specular();
    /// Runs work(), and turns exceptions into errors.
    Result<Done> guarded_work(const ViewJob& job, const Progress& progress);
    Result<Done> work(const ViewJob& job, const Progress& progress);
    void show_colours(Exactness exactness);
    /// True if the colours are those of the present design.
    bool is_shown(bool with_exposure = true) const;
    void tell_trouble(const Error& error);
    void tell_rest();
    /// Sends the measured error to a page.
    void tell_error(PageId page) const;

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
    Scene saved_;      ///< The scene as in its file, or in the file that was saved last.
    Scene autosaved_;  ///< The scene as in the autosave file; `saved_` if there is none.
    bool autosave_has_failed_ = false;
    std::optional<Scene> left_;  ///< The autosaved scene of an earlier session, until a page decides.

    // Used by the session's thread alone.
    std::vector<PageId> pages_;                  ///< The first page steers.
    Camera window_;                              ///< The view of the steering page.
    Variation hand_;                             ///< The variation of the last gesture.
    Variation likely_{Variation::Of::light, 0};  ///< The likely variation of the next gesture.
    std::optional<Design> shown_;                ///< The design that the displayed colours belong to.
    Exactness exactness_ = Exactness::moving;
    std::optional<BakeError> error_;  ///< Of exact colours in the window, once it is measured.
    std::optional<Design> told_;      ///< The state that the pages have.
    bool sent_undo_ = false, sent_redo_ = false;
    /// The design's camera differs from the last one that the steering page sent.
    bool has_stepped_ = false;
    std::optional<std::uint64_t> failed_light_;  ///< Stamp of a light with which work has failed.
    std::uint32_t frame_ = 0, last_message_ = 0;
    MessageHead last_head_;  ///< Of the last applied message, for errors of the resulting work.
    Clock::time_point message_time_, last_input_;
    SharedBytes last_frame_;
    std::pair<std::uint32_t, std::uint32_t> sent_still_;  ///< Message and frame.
    std::vector<std::pair<PageId, bool>> pictures_;  ///< Requested pictures, made when the colours are exact.

    // Shared by all threads.
    std::atomic<bool> has_specular_ = true;  ///< True if colours depend on the eye.
    mutable std::mutex mutex_;
    std::condition_variable_any woken_;
    std::deque<Arrival> arrivals_;
    ViewJob job_;                ///< The running job,
    std::stop_source stop_job_;  ///< and its stop source.
    Clock::time_point sent_work_;
    Vec3f last_eye_;       ///< In the messages that have arrived.
    PageId steering_ = 0;  ///< The page whose messages end jobs: the first of pages_.

    std::jthread thread_;  ///< Last, because it uses all other members.
};

}  // namespace haarfield
