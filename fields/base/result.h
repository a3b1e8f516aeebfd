#pragma once
/// Bad input is a value: what a function returns that reads, writes or runs something from outside.

#include <cassert>
#include <string>
#include <utility>
#include <variant>

namespace haarfield {

/// What went wrong, for a person to read.
struct Error {
    std::string where;  ///< `file`, `file:line` or `file:line:column`.
    std::string what;   ///< What was found; what was wanted.

    /// Place and matter in one line.
    std::string message() const { return where.empty() ? what : where + ": " + what; }
};

/// A T, or the reason why there is none. Reading the wrong one is a caller's bug (asserted).
template <class T>
class [[nodiscard]] Result {
public:
    Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}  ///< A value.
    /// The reason why there is none.
    Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

    explicit operator bool() const { return state_.index() == 0; }  ///< Whether there is a value.

    T& operator*() & { return checked_value(); }  ///< The value; only where there is one.
    /// The value; only where there is one.
    const T& operator*() const& { return const_cast<Result*>(this)->checked_value(); }
    T&& operator*() && { return std::move(checked_value()); }  ///< The value; only where there is one.
    T* operator->() { return &checked_value(); }               ///< The value; only where there is one.
    /// The value; only where there is one.
    const T* operator->() const { return &const_cast<Result*>(this)->checked_value(); }

    /// The reason; only where there is no value.
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
