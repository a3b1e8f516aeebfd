#pragma once
/// Results of functions that read, write or run something external: bad input is a value, not an exception.

#include <cassert>
#include <string>
#include <utility>
#include <variant>

/// Declares a variable with the value of a Result; a function returns the error if there is none.
///
/// declaration  without commas: `const Scene scene`.
/// ...          an expression of type Result<T>. The macro is several statements, so it needs a block.
#define HF_TRY(declaration, ...) HF_TRY_AS(HF_NAME_OF_LINE(hf_result_, __LINE__), declaration, __VA_ARGS__)
/// Evaluates an expression of type Result<T> for its effect; a function returns the error if it failed.
#define HF_TRY_DONE(...)                                                              \
    do                                                                                \
        if (const auto hf_result = __VA_ARGS__; !hf_result) return hf_result.error(); \
    while (false)
/// The statements of HF_TRY, with a name for the Result.
#define HF_TRY_AS(result, declaration, ...) \
    auto result = __VA_ARGS__;              \
    if (!result) return result.error();     \
    declaration = *std::move(result)
/// A name that is unique on a line.
#define HF_NAME_OF_LINE(name, line) HF_JOINED(name, line)
/// A name followed by the number of a line.
#define HF_JOINED(name, line) name##line

namespace haarfield {

/// The kinds of failure that callers distinguish.
enum class ErrorCode { failed, interrupted };

/// An error message for a person.
struct Error {
    std::string where;  ///< `file`, `file:line` or `file:line:column`.
    std::string what;   ///< What was found, and what was expected.
    ErrorCode code = ErrorCode::failed;

    /// Returns place and description in one line.
    std::string message() const { return where.empty() ? what : where + ": " + what; }
};

/// A T, or the error that prevented it. Reading the wrong alternative is a caller's bug (asserted).
template <class T>
class [[nodiscard]] Result {
public:
    Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}  ///< Success.
    /// Failure.
    Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

    explicit operator bool() const { return state_.index() == 0; }  ///< True if there is a value.

    T& operator*() & { return checked_value(); }  ///< The value; requires success.
    /// The value; requires success.
    const T& operator*() const& { return const_cast<Result*>(this)->checked_value(); }
    T&& operator*() && { return std::move(checked_value()); }  ///< The value; requires success.
    T* operator->() { return &checked_value(); }               ///< The value; requires success.
    /// The value; requires success.
    const T* operator->() const { return &const_cast<Result*>(this)->checked_value(); }

    /// The error; requires failure.
    const Error& error() const {
        assert(!*this);
        return std::get<1>(state_);
    }

private:
    T& checked_value() {
        assert(*this);
        return std::get<0>(state_);
    }

    std::variant<T, Error> state_;
};

/// The value of an action that returns nothing but may fail.
struct Done {};

}  // namespace haarfield
