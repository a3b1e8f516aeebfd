#pragma once
/// Results of functions that read, write or run something external: bad input is a value, not an exception.

#include <cassert>
#include <string>
#include <utility>
#include <variant>

namespace haarfield {

/// An error message for a person.
struct Error {
    std::string where;  ///< `file`, `file:line` or `file:line:column`.
    std::string what;   ///< What was found, and what was expected.

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
