#include "scenes/scene_comments.h"

#include <algorithm>

namespace haarfield {
namespace {

/// Tests whether a line contains a comment or an unterminated quotation.
bool has_comment(std::string_view line) {
    char quote = 0;  // The quotation mark of the string at `i`; 0 outside strings.
    for (std::size_t i = 0; i < line.size(); ++i) {
        const char c = line[i];
        if (quote != 0) {
            if (c == '\\' && quote == '"')
                ++i;
            else if (c == quote)
                quote = 0;
        } else if (c == '"' || c == '\'') {
            quote = c;
        } else if (c == '#') {
            return true;
        }
    }
    return quote != 0;
}

}  // namespace

SceneComments scene_comments(std::string_view text) {
    SceneComments comments;
    bool is_on_top = true;
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        std::string_view line = text.substr(0, end);
        text.remove_prefix(std::min(end + 1, text.size()));
        if (line.ends_with('\r')) line.remove_suffix(1);
        is_on_top = is_on_top && line.starts_with('#');
        if (is_on_top) {
            line.remove_prefix(line.starts_with("# ") ? 2 : 1);
            comments.on_top.append(line) += '\n';
        } else if (has_comment(line)) {
            comments.has_others = true;
        }
    }
    return comments;
}

}  // namespace haarfield
