#pragma once
/// What a person has written into a scene file beside the scene: comments, of which scene_text keeps some.

#include <string>
#include <string_view>

namespace haarfield {

/// The comments of a scene file.
struct SceneComments {
    std::string on_top;       ///< The lines of comments before all else, without `#`: what scene_text keeps.
    bool has_others = false;  ///< There are some further down, which it does not keep.
};

/// The comments of a text.
///
/// text     of a scene file. Where quotation marks do not end with their line, as in no file that read_scene
///          takes, it counts as one with further comments.
SceneComments scene_comments(std::string_view text);

}  // namespace haarfield
