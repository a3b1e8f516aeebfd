#pragma once
/// The scene that pages edit: its design, its files, and the messages that change them.

#include "tools/view/scene_file.h"
#include "tools/view/session_pages.h"

namespace haarfield {

/// The effect of a message on the window, which is the view of the steering page.
enum class WindowChange {
    none,
    by_page,  ///< The page has sent its view.
    by_step,  ///< Undo, redo or restoring has changed the design's camera; the page must adopt it.
};

/// Applies messages of the steering page to the scene, and saves it. One thread calls all functions.
class SceneEditor {
public:
    /// file                the scene's file; empty: changes are not autosaved.
    /// live, shelf, pages  must outlive the editor.
    SceneEditor(const Scene& scene, const std::filesystem::path& file, LiveScene& live,
                const LightShelf& shelf, const SessionPages& pages);

    const History& history() const { return history_; }
    const Design& now() const { return history_.now(); }
    const Camera& window() const { return window_; }     ///< The view of the steering page.
    const Variation& hand() const { return hand_; }      ///< The variation of the last gesture.
    const Variation& likely() const { return likely_; }  ///< The likely variation of the next gesture.

    /// Applies a message. Messages about steering, tasks and frames change nothing here. Defined in
    /// messages.cpp, next to the readers of messages.
    ///
    /// page    receives the answer to `save`.
    /// errors  those of History::make and SceneFile; unknown lights, objects and parts; nothing to undo, redo
    ///         or restore.
    Result<WindowChange> apply(PageId page, const Message& message);
    void end_gesture() { history_.end_gesture(); }

    void read_left_scene();  ///< Reads the autosaved scene of an earlier session, if there is one.
    /// The file of that scene; empty if there is none, or a page has decided.
    std::filesystem::path left_file() const { return left_ ? file_.autosave_file() : ""; }
    void autosave();  ///< Writes unsaved changes next to the scene; removes that file if there are none.

private:
    Result<WindowChange> make_edit(const Edit& edit, const Message& message, const Variation& hand);
    Result<WindowChange> take_lights(const NamedLights& lights, const Message& message);
    Result<WindowChange> own_part(const EditPartMaterial& part, const Message& message);
    Result<WindowChange> take_look(const SetView& look, const Message& message);
    Result<WindowChange> save(PageId page, const Save& save, const Message& message);
    WindowChange look_as_designed();

    LiveScene& live_;
    const LightShelf& shelf_;
    const SessionPages& pages_;
    History history_;
    SceneFile file_;
    Scene saved_ = history_.now().scene;  ///< The scene as in its file, or in the file that was saved last.
    Scene autosaved_ = saved_;            ///< The scene as in the autosave file; `saved_` if there is none.
    bool autosave_has_failed_ = false;
    std::optional<Scene> left_;  ///< The autosaved scene of an earlier session, until a page decides.
    Camera window_;
    Variation hand_;
    Variation likely_{Variation::Of::light, 0};
};

}  // namespace haarfield
