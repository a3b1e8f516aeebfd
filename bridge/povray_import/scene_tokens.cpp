#include "bridge/povray_import/scene_tokens.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace haarfield {
namespace {

bool is_letter(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}
bool is_digit(char c) {
    return c >= '0' && c <= '9';
}
bool is_blank(char c) {
    return c == ' ' || (c >= '\t' && c <= '\r') || c == '\0' || c == '\x1a';
}

/// Divides a text into tokens.
class Tokenizer {
public:
    explicit Tokenizer(std::string_view text) : text_(text) {}

    Result<std::vector<SceneToken>> all() {
        // Editors mark files as UTF-8 by three bytes.
        if (text_.starts_with("\xef\xbb\xbf")) at_ = 3;
        std::vector<SceneToken> tokens;
        while (true) {
            if (!skip_blanks()) return unterminated(comment_, "comment", "*/");
            if (at_ == text_.size()) return tokens;
            const std::size_t begin = at_;
            SceneToken token = next();
            if (token.kind == SceneToken::Kind::string && at_ > text_.size())
                return unterminated(begin, "string", "\"");
            token.begin = begin;
            token.end = at_;
            tokens.push_back(token);
        }
    }

private:
    using Kind = SceneToken::Kind;

    Error unterminated(std::size_t place, std::string_view what, std::string_view end) const {
        return Error{"", fmt::format("line {}: found the end of the file in a {}; expected {}",
                                     line_of_place(text_, place), what, end)};
    }

    char character(std::size_t ahead = 0) const {
        return at_ + ahead < text_.size() ? text_[at_ + ahead] : '\0';
    }

    /// Skips blanks and comments. Returns false in an unterminated comment.
    bool skip_blanks() {
        while (at_ < text_.size()) {
            if (is_blank(text_[at_])) {
                ++at_;
            } else if (text_.substr(at_, 2) == "//") {
                at_ = std::min(text_.find('\n', at_), text_.size());
            } else if (text_.substr(at_, 2) == "/*") {
                comment_ = at_;
                std::size_t depth = 0;
                do {
                    if (at_ >= text_.size()) return false;
                    const std::string_view pair = text_.substr(at_, 2);
                    depth += pair == "/*";
                    depth -= pair == "*/";
                    at_ += pair == "/*" || pair == "*/" ? 2 : 1;
                } while (depth > 0);
            } else {
                break;
            }
        }
        return true;
    }

    std::string_view word() {
        const std::size_t begin = at_;
        while (is_letter(character()) || is_digit(character())) ++at_;
        return text_.substr(begin, at_ - begin);
    }

    SceneToken next() {
        const std::size_t begin = at_;
        const char c = character();
        if (is_letter(c)) return {Kind::word, 0, 0, word()};
        if (is_digit(c) || (c == '.' && is_digit(character(1)))) {
            number();
            return {Kind::number, 0, 0, text_.substr(begin, at_ - begin)};
        }
        ++at_;
        if (c == '"') {
            while (at_ < text_.size() && text_[at_] != '"') at_ += text_[at_] == '\\' ? 2 : 1;
            const std::size_t end = std::min(at_, text_.size());
            ++at_;
            return {Kind::string, 0, 0, text_.substr(begin + 1, end - begin - 1)};
        }
        if (c == '#') {
            while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
            return {Kind::directive, 0, 0, word()};
        }
        if ((c == '!' || c == '<' || c == '>') && character() == '=') ++at_;
        return {Kind::symbol, 0, 0, text_.substr(begin, at_ - begin)};
    }

    void number() {
        while (is_digit(character())) ++at_;
        if (character() == '.') ++at_;
        while (is_digit(character())) ++at_;
        const bool is_signed = character(1) == '-' || character(1) == '+';
        if ((character() == 'e' || character() == 'E') && is_digit(character(is_signed ? 2 : 1))) {
            at_ += is_signed ? 2 : 1;
            while (is_digit(character())) ++at_;
        }
    }

    std::string_view text_;
    std::size_t at_ = 0, comment_ = 0;  ///< The place, and that of the last comment.
};

bool opens_block(const SceneToken& token) {
    constexpr std::array words{"if", "ifdef", "ifndef", "while", "for", "switch", "macro"};
    return token.kind == SceneToken::Kind::directive && std::ranges::find(words, token.text) != words.end();
}

bool starts_branch(const SceneToken& token) {
    constexpr std::array words{"else", "elseif", "case", "range"};
    return token.kind == SceneToken::Kind::directive && std::ranges::find(words, token.text) != words.end();
}

bool is_opening(const SceneToken& token) {
    return token.is('{') || token.is('(') || token.is('[');
}
bool is_closing(const SceneToken& token) {
    return token.is('}') || token.is(')') || token.is(']');
}

/// Finds the ends of expressions.
class ExpressionEnd {
public:
    explicit ExpressionEnd(std::span<const SceneToken> tokens) : tokens_(tokens) {}

    /// Returns the index behind the expression at `at`; `at` if there is none.
    std::size_t of(std::size_t at, int depth = 0) const {
        if (depth > deepest) return at;
        std::size_t end = operand(at, depth);
        while (end > at && end < tokens_.size() && is_operator(tokens_[end])) {
            const std::size_t next = operand(end + 1, depth);
            if (next == end + 1) break;
            end = next;
        }
        return end;
    }

private:
    static constexpr int deepest = 200;

    static bool is_operator(const SceneToken& token) {
        return token.is('+') || token.is('-') || token.is('*') || token.is('/');
    }
    static bool is_colour_word(const SceneToken& token) {
        constexpr std::array words{"color", "colour", "rgb",      "rgbf",   "rgbt", "rgbft",
                                   "srgb",  "srgbf",  "srgbt",    "srgbft", "red",  "green",
                                   "blue",  "filter", "transmit", "alpha",  "gray"};
        return token.kind == SceneToken::Kind::word && std::ranges::find(words, token.text) != words.end();
    }
    static bool is_channel(const SceneToken& token) {
        constexpr std::array words{"red", "green", "blue", "filter", "transmit"};
        return token.kind == SceneToken::Kind::word && std::ranges::find(words, token.text) != words.end();
    }

    bool opens(std::size_t at, char symbol) const { return at < tokens_.size() && tokens_[at].is(symbol); }

    /// Skips `[i]` and `.x`.
    std::size_t behind_selectors(std::size_t end) const {
        while (end < tokens_.size()) {
            if (tokens_[end].is('[')) {
                const std::size_t behind = end_of_group(tokens_, end);
                if (behind == 0) return end;
                end = behind;
            } else if (tokens_[end].is('.') && end + 1 < tokens_.size() &&
                       tokens_[end + 1].kind == SceneToken::Kind::word) {
                end += 2;
            } else {
                break;
            }
        }
        return end;
    }

    std::size_t behind_group(std::size_t at, std::size_t otherwise) const {
        const std::size_t end = end_of_group(tokens_, at);
        return end == 0 ? otherwise : end;
    }

    std::size_t vector(std::size_t at, int depth) const {
        std::size_t end = at + 1;
        while (end < tokens_.size() && !tokens_[end].is('>')) {
            const std::size_t next = tokens_[end].is(',') ? end + 1 : of(end, depth + 1);
            if (next == end) return at;
            end = next;
        }
        return end < tokens_.size() ? behind_selectors(end + 1) : at;
    }

    std::size_t operand(std::size_t at, int depth) const {
        std::size_t begin = at;
        while (begin < tokens_.size() &&
               (tokens_[begin].is('-') || tokens_[begin].is('+') || tokens_[begin].is('!')))
            ++begin;
        if (begin >= tokens_.size()) return at;
        const SceneToken& first = tokens_[begin];
        using Kind = SceneToken::Kind;
        if (first.kind == Kind::number || first.kind == Kind::string) return begin + 1;
        if (first.is('(')) return behind_selectors(behind_group(begin, at));
        if (first.is('<')) {
            const std::size_t end = vector(begin, depth);
            return end == begin ? at : end;
        }
        if (first.kind == Kind::directive)
            return opens_block(first) && first.text != "macro" ? end_of_block(tokens_, begin) : at;
        if (first.kind != Kind::word) return at;
        if (is_colour_word(first)) return colour(begin, at, depth);
        return word(begin, at);
    }

    std::size_t colour(std::size_t begin, std::size_t otherwise, int depth) const {
        if (depth > deepest) return otherwise;
        std::size_t end = operand(begin + 1, depth + 1);
        if (end == begin + 1) return otherwise;
        while (end < tokens_.size() && is_channel(tokens_[end])) {
            const std::size_t next = of(end + 1, depth + 1);
            if (next == end + 1) break;
            end = next;
        }
        return end;
    }

    std::size_t word(std::size_t begin, std::size_t otherwise) const {
        std::size_t end = begin + 1;
        if (tokens_[begin].text == "array") {
            while (opens(end, '[')) end = behind_group(end, tokens_.size());
            return opens(end, '{') ? behind_group(end, otherwise) : end;
        }
        if (tokens_[begin].text == "function" && opens(end, '(')) {
            end = behind_group(end, tokens_.size());
            return opens(end, '{') ? behind_group(end, otherwise) : otherwise;
        }
        if (opens(end, '(')) return behind_selectors(behind_group(end, otherwise));
        if (opens(end, '{')) {
            end = behind_group(end, otherwise);
            // Layers of a texture.
            while (tokens_[begin].text == "texture" && end + 1 < tokens_.size() &&
                   tokens_[end].is_word("texture") && opens(end + 1, '{'))
                end = behind_group(end + 1, tokens_.size());
            return end;
        }
        return behind_selectors(end);
    }

    std::span<const SceneToken> tokens_;
};

}  // namespace

Result<std::vector<SceneToken>> scene_tokens(std::string_view text) {
    return Tokenizer(text).all();
}

std::size_t line_of_place(std::string_view text, std::size_t place) {
    const std::string_view before = text.substr(0, place);
    return 1 + static_cast<std::size_t>(std::ranges::count(before, '\n'));
}

std::size_t end_of_group(std::span<const SceneToken> tokens, std::size_t at) {
    std::size_t depth = 0;
    std::vector<std::size_t> depths;  // At the starts of open conditions.
    for (std::size_t i = at; i < tokens.size(); ++i) {
        const SceneToken& token = tokens[i];
        if (opens_block(token)) {
            depths.push_back(depth);
        } else if (starts_branch(token)) {
            if (depths.empty()) return 0;
            depth = depths.back();
        } else if (token.is_directive("end")) {
            if (depths.empty()) return 0;
            depths.pop_back();
        } else if (is_opening(token)) {
            ++depth;
        } else if (is_closing(token)) {
            if (depth == 0) return 0;
            if (--depth == 0 && depths.empty()) return i + 1;
        }
    }
    return 0;
}

std::size_t end_of_block(std::span<const SceneToken> tokens, std::size_t at) {
    std::size_t depth = 0;
    for (std::size_t i = at; i < tokens.size(); ++i) {
        depth += opens_block(tokens[i]);
        if (tokens[i].is_directive("end") && --depth == 0) return i + 1;
    }
    return tokens.size();
}

std::size_t end_of_expression(std::span<const SceneToken> tokens, std::size_t at) {
    return ExpressionEnd(tokens).of(at);
}

}  // namespace haarfield
