#pragma once
/// Work that lasts: without Python's lock, with progress, ended by Ctrl-C.

#include "fields/base/progress.h"
#include "fields/base/result.h"

#include <pybind11/pybind11.h>

#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace haarfield::python {

namespace py = pybind11;

/// What a haarfield.Error says.
[[noreturn]] void raise(const Error& error);

/// The value, or haarfield.Error.
template <class T>
T value_of(Result<T> result) {
    if (!result) raise(result.error());
    return *std::move(result);
}

/// Does work in a thread of its own while the calling one waits without Python's lock, and looks twenty times
/// a second whether Python has signals to handle and what the progress is.
///
/// progress  a callable(stage, done, total), or None. What it raises ends the work, as Ctrl-C does.
/// work      must end soon after a stop is requested; what it throws is thrown here.
void do_watched(const py::object& progress, const std::function<void(const Progress&)>& work);

/// The same for what has a value or fails.
template <class T>
T long_call(const py::object& progress, const std::function<Result<T>(const Progress&)>& work) {
    std::optional<Result<T>> result;
    do_watched(progress, [&](const Progress& watched) { result.emplace(work(watched)); });
    return value_of(std::move(*result));
}

/// haarfield.Warning for each, as Python's `warnings` wants them handled.
void warn(const std::vector<std::string>& warnings);

/// Held while one thread works on what others may want, too: waits until it is free, or a stop is requested.
/// Never while Python's lock is held.
class Turn {
public:
    Turn(std::timed_mutex& mutex, const Progress& progress);

    /// Whether it is this thread's turn; if not, the call is interrupted.
    explicit operator bool() const { return lock_.owns_lock(); }

private:
    std::unique_lock<std::timed_mutex> lock_;
};

/// Adds Error and Warning to the module.
void add_errors(py::module_& module);

}  // namespace haarfield::python
