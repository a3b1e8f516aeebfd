#pragma once
/// The comments of scene files, some of which scene_text preserves.

#include <string>
#include <string_view>

namespace haarfield {

/// The comments of a scene file.
struct SceneComments {
    std::string on_top;       ///< The lines of comments at the top, without `#`: scene_text preserves them.
    bool has_others = false;  ///< Some comments follow further down: scene_text loses them.
};

/// Finds the comments of a scene file's text. A line with an unterminated quotation mark, which read_scene
/// refuses, counts as one with a comment.
SceneComments scene_comments(std::string_view text);

}  // namespace haarfield
