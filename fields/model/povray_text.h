#pragma once
/// POV-Ray's scene description language, as far as plain data goes.

#include "fields/base/result.h"
#include "fields/base/vector.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace haarfield {

/// Walks over a text word by word; blanks and comments (`//`, and nested `/* */`) are passed over.
///
/// The first thing that is not as it is wanted fails the whole walk: from then on the text is at its end, and
/// all that is taken from it is empty or zero. Whoever walks asks `failed` in the end. Nothing is evaluated:
/// identifiers, calls and sums where a number is wanted are failures.
///
/// cost  proportional to what is walked over; a copy is cheap, and walks by itself.
class PovrayText {
public:
    explicit PovrayText(std::string_view text) : text_(text) { pass_over_blanks(); }

    bool at_end() const { return at_ == text_.size(); }           ///< Nothing is left.
    char next() const { return at_end() ? '\0' : text_[at_]; }    ///< What comes next; '\0' at the end.
    std::size_t place() const { return at_; }                     ///< Of what comes next. [bytes]
    std::size_t remaining() const { return text_.size() - at_; }  ///< [bytes]
    std::size_t line_at(std::size_t place) const;                 ///< From 1. cost: linear.

    /// Why a walk ended.
    struct Failure {
        std::size_t place;
        std::string what;
    };
    bool failed() const { return failure_.has_value(); }                ///< Whether there is a failure.
    const std::optional<Failure>& failure() const { return failure_; }  ///< The first one.
    Error error() const;  ///< The failure as `line 3: ...`, with an empty `where`; only where there is one.

    /// Fails at a place; only the first failure counts.
    void fail_at(std::size_t place, std::string what);
    /// Fails in the line of what comes next: "WANTED; found ...".
    void fail(std::string_view wanted);

    bool take(char c);          ///< Whether this comes next; if so, passes over it.
    void expect(char c);        ///< Passes over it, or fails.
    std::string_view word();    ///< Takes an identifier or keyword; empty if there is none.
    std::string_view string();  ///< Takes what stands in double quotes; empty if there is none.
    void pass_over_one();       ///< A word, a number, a string or a single character.
    void pass_over_braces();    ///< From a `{`, which must come next, to the `}` that ends it.

    std::uint32_t count();  ///< Takes a whole number in [0, 2^32).
    double number();        ///< Takes a number with its signs. Out of range it is infinite or zero.
    /// Takes `<a, b, c>`, `x`, `-1.5*y`, `2*<a, b, c>`, or a number that stands for all three.
    Vec3d vector();
    std::array<float, 2> uv();               ///< Takes `<u, v>`.
    std::array<std::uint32_t, 3> indices();  ///< Takes `<a, b, c>`.
    /// Takes `<12 numbers>`.
    std::array<double, 12> matrix();

private:
    void pass_over_blanks();
    bool pass_over_block_comment();
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
