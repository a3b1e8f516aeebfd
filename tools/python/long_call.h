#pragma once
/// Runs long work without the GIL, with progress, interruptible by Ctrl-C.

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

/// Raises haarfield.Error.
[[noreturn]] void raise(const Error& error);

/// Returns the value, or raises haarfield.Error.
template <class T>
T value_of(Result<T> result) {
    if (!result) raise(result.error());
    return *std::move(result);
}

/// Runs work in a separate thread while the calling thread waits without the GIL. The calling thread handles
/// Python's signals and reports progress twenty times per second.
///
/// progress  a callable(stage, done, total), or None. An exception that it raises ends the work, as Ctrl-C
///           does.
/// work      must end soon after a stop is requested. Its exceptions are rethrown here.
void do_watched(const py::object& progress, const std::function<void(const Progress&)>& work);

/// Runs work that returns a Result, like do_watched. Returns the value or raises haarfield.Error.
template <class T>
T long_call(const py::object& progress, const std::function<Result<T>(const Progress&)>& work) {
    std::optional<Result<T>> result;
    do_watched(progress, [&](const Progress& watched) { result.emplace(work(watched)); });
    return value_of(std::move(*result));
}

/// Issues a haarfield.Warning for each text, subject to Python's warning filters.
void warn(const std::vector<std::string>& warnings);

/// A lock on data that several threads use. Waits until the lock is free or a stop is requested. Must not be
/// waited for with the GIL held.
class Turn {
public:
    Turn(std::timed_mutex& mutex, const Progress& progress);

    /// True if the lock was acquired; otherwise the call is interrupted.
    explicit operator bool() const { return lock_.owns_lock(); }

private:
    std::unique_lock<std::timed_mutex> lock_;
};

/// Adds Error and Warning to the module.
void add_errors(py::module_& module);

}  // namespace haarfield::python
