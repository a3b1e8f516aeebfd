#pragma once
/// A tokenizer for plain data in POV-Ray's scene description language.

#include "fields/base/result.h"
#include "fields/base/vector.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace haarfield {

/// Reads a text word by word. Skips blanks and comments (`//`, and nested `/* */`).
///
/// The first violation of the expected syntax fails the text: it is then at its end, and all further reads
/// return empty or zero. Callers test `failed` once, at the end. Nothing is evaluated: an identifier, call or
/// sum in place of a number is a failure.
///
/// cost  proportional to the text that is read. Copies are cheap and independent.
class PovrayText {
public:
    /// Refers to the text, which must outlive the reader.
    explicit PovrayText(std::string_view text) : text_(text) { skip_blanks(); }

    bool at_end() const { return at_ == text_.size(); }           ///< True if no text remains.
    char next() const { return at_end() ? '\0' : text_[at_]; }    ///< The next character; '\0' at the end.
    std::size_t place() const { return at_; }                     ///< Offset of the next character. [bytes]
    std::size_t remaining() const { return text_.size() - at_; }  ///< [bytes]
    std::size_t line_at(std::size_t place) const;                 ///< Line of a place, from 1. cost: linear.

    /// The reason why reading failed.
    struct Failure {
        std::size_t place;
        std::string what;
    };
    bool failed() const { return failure_.has_value(); }                ///< True after a failure.
    const std::optional<Failure>& failure() const { return failure_; }  ///< The first failure.
    Error error() const;  ///< The failure as `line 3: ...`, with an empty `where`; requires a failure.

    /// Fails at a place. Only the first failure is kept.
    void fail_at(std::size_t place, std::string what);
    /// Fails at the next character with the message "found ...; expected WANTED".
    void fail(std::string_view wanted);

    bool take(char c);          ///< Skips the character if it is next. Returns true if so.
    void expect(char c);        ///< Skips the character, or fails.
    std::string_view word();    ///< Reads an identifier or keyword; empty if there is none.
    std::string_view string();  ///< Reads a string in double quotes; empty if there is none.
    void skip_one();            ///< Skips a word, a number, a string or a single character.
    void skip_braces();         ///< Skips from a `{`, which must be next, to its closing `}`.

    std::uint32_t count();  ///< Reads an integer in [0, 2^32).
    double number();        ///< Reads a number with its signs. Out of range, it becomes infinite or zero.
    /// Reads `<a, b, c>`, `x`, `-1.5*y`, `2*<a, b, c>`, or a number that is used for all three.
    Vec3d vector();
    std::array<float, 2> uv();               ///< Reads `<u, v>`.
    std::array<std::uint32_t, 3> indices();  ///< Reads `<a, b, c>`.
    /// Reads `<12 numbers>`.
    std::array<double, 12> matrix();

private:
    void skip_blanks();
    bool skip_block_comment();
    double unsigned_number();
    double sign();
    void refuse_operator();
    template <std::size_t count>
    std::array<double, count> numbers();

    std::string_view text_;
    std::size_t at_ = 0;
    std::optional<Failure> failure_;
};

}  // namespace haarfield
