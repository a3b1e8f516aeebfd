#pragma once
/// Tokens of a text in POV-Ray's scene description language.

#include "fields/base/result.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace haarfield {

/// One token of a scene's text. Comments and blanks are between tokens.
struct SceneToken {
    /// The kinds of tokens.
    enum class Kind : std::uint8_t {
        word,       ///< A keyword or identifier.
        number,     ///< An unsigned number.
        string,     ///< A string; `text` is without its quotation marks.
        symbol,     ///< A character, or one of `!=`, `<=`, `>=`.
        directive,  ///< `#word`; `text` is the word.
    };
    Kind kind = Kind::symbol;
    std::size_t begin = 0, end = 0;  ///< The token's place in the text. [bytes]
    std::string_view text;           ///< Refers to the text.

    bool is_word(std::string_view word) const { return kind == Kind::word && text == word; }  ///< Exact.
    /// Tests for a symbol.
    bool is(char symbol) const { return kind == Kind::symbol && text.size() == 1 && text.front() == symbol; }
    /// Tests for a directive.
    bool is_directive(std::string_view word) const { return kind == Kind::directive && text == word; }
};

/// Divides a text into tokens. Evaluates nothing.
///
/// text    must outlive the tokens.
/// errors  (with an empty `where`, and the line) an unterminated comment or string.
/// cost    proportional to the text; 48 bytes of memory per token.
Result<std::vector<SceneToken>> scene_tokens(std::string_view text);

/// Returns the line of a place in a text, from 1. cost: linear.
std::size_t line_of_place(std::string_view text, std::size_t place);

/// Returns the index behind the braces, brackets or parentheses that open at `at`. Of a condition, the last
/// branch counts: the branches of `#if` need not balance, as long as all of them open and close equally many.
/// Returns 0 if the tokens end first, or if a condition ends that began before `at`.
std::size_t end_of_group(std::span<const SceneToken> tokens, std::size_t at);

/// Returns the index behind the `#end` of the condition, loop or macro whose directive is at `at`; the number
/// of tokens if there is none.
std::size_t end_of_block(std::span<const SceneToken> tokens, std::size_t at);

/// Returns the index behind the expression that starts at `at`: a number, vector, colour, string, array, an
/// object with its braces, a call, or an arithmetic expression of these. A chain of `texture { }` is one
/// expression, and so is a condition. Returns `at` if no expression starts there.
std::size_t end_of_expression(std::span<const SceneToken> tokens, std::size_t at);

}  // namespace haarfield
