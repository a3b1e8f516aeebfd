#pragma once
/// The pages of a session: which page steers, what the pages have been told, and how to tell them.

#include "tools/view/light_shelf.h"
#include "tools/view/messages.h"
#include "tools/view/scene_assets.h"

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>

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

/// The constant keys of the text `scene`.
struct SessionFacts {
    std::string session;  ///< A word that identifies the session.
    std::string file;     ///< The name of the scene's file.
    int bounces;          ///< any_bounces: no limit.
};

/// The pages of a session. Other threads than the session's may call the functions above join() only.
class SessionPages {
public:
    using Clock = std::chrono::steady_clock;

    /// live, shelf  must outlive the pages.
    SessionPages(const LiveScene& live, const LightShelf& shelf, SessionFacts facts, Audience audience);

    void tell(PageId page, const std::string& text) const { audience_.tell(page, text); }
    void tell_all(const std::string& text) const { audience_.tell_all(text); }
    void shown(PageId page) const { audience_.shown(page); }
    void answer(PageId page, const Error& error, const MessageHead& to) const;
    /// Reports work, at most every 100 ms. Its end (`doing` is empty) is always reported.
    void tell_work(const char* doing, std::string_view stage, double share);

    /// Adds a page and sends it the whole state.
    ///
    /// left   see tell_left_scene.
    /// error  of the colours, once it is measured.
    void join(PageId page, const History& history, const std::filesystem::path& left,
              const std::optional<BakeError>& error);
    bool leave(PageId page);  ///< Removes a page. Returns true if the next page takes over steering.
    bool steer(PageId page);  ///< Makes a page steer. Returns false if the page has not joined.
    const std::vector<PageId>& all() const { return pages_; }
    bool steers(PageId page) const { return !pages_.empty() && pages_.front() == page; }
    PageId steering() const { return pages_.empty() ? 0 : pages_.front(); }  ///< 0: there is no page.

    /// Sets the last applied message, to which states, frames and errors of work refer.
    void set_last_message(const MessageHead& head, Clock::time_point arrival);
    /// Sets whether undo or redo has set the camera, so that the steering page adopts it from the next state.
    void set_stepped(bool has_stepped) { has_stepped_ = has_stepped; }

    void tell_state(const History& history);  ///< Sends the changes since the last call.
    void tell_lights(const History& history) const;
    /// file  the autosave file of an earlier session; empty: none, or a page has decided.
    void tell_left_scene(PageId page, const std::filesystem::path& file) const;
    void show_colours(const Design& design, Exactness exactness);
    void tell_rest();  ///< The last frame is exact and includes all messages.
    void tell_error(PageId page, const BakeError& error) const;  ///< Of the last frame.
    void tell_trouble(const Error& error) const;                 ///< Work for the last message has failed.

private:
    nlohmann::json state(const History& history, bool all) const;
    void tell_scene(PageId page, const History& history) const;

    const LiveScene& live_;
    const LightShelf& shelf_;
    SessionFacts facts_;
    Audience audience_;
    std::vector<PageId> pages_;   ///< The first page steers.
    std::optional<Design> told_;  ///< The state that the pages have.
    bool sent_undo_ = false, sent_redo_ = false;
    bool has_stepped_ = false;
    MessageHead last_head_;
    Clock::time_point message_time_;
    std::uint32_t frame_ = 0;
    SharedBytes last_frame_;
    std::pair<std::uint32_t, std::uint32_t> sent_still_;  ///< Message and frame.
    std::atomic<Clock::time_point> sent_work_;
};

}  // namespace haarfield
