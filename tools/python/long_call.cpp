#include "tools/python/long_call.h"

#include "fields/base/exception_message.h"

#include <chrono>
#include <condition_variable>
#include <exception>
#include <new>
#include <thread>

namespace haarfield::python {

namespace {

constexpr std::chrono::milliseconds between_looks{50};

// Borrowed references; the module lives as long as the interpreter.
PyObject* error_class = nullptr;
PyObject* warning_class = nullptr;

/// The state that the two threads share.
struct Watch {
    std::mutex mutex;
    std::condition_variable change;
    bool is_done = false;
    bool has_news = false;
    std::string stage;
    std::uint64_t done = 0, total = 0;
    std::exception_ptr thrown;
};

/// Reports progress to Python. Requires the GIL; throws Python's exceptions.
void tell(Watch& watch, const py::object& progress) {
    std::string stage;
    std::uint64_t done = 0, total = 0;
    {
        const std::lock_guard lock(watch.mutex);
        if (!watch.has_news) return;
        watch.has_news = false;
        stage = watch.stage;
        done = watch.done;
        total = watch.total;
    }
    if (!progress.is_none()) progress(stage, done, total);
}

}  // namespace

void raise(const Error& error) {
    py::object raised = py::reinterpret_borrow<py::object>(error_class)(error.message());
    raised.attr("where") = error.where;
    raised.attr("what") = error.what;
    PyErr_SetObject(error_class, raised.ptr());
    throw py::error_already_set();
}

void do_watched(const py::object& progress, const std::function<void(const Progress&)>& work) {
    if (!progress.is_none() && !PyCallable_Check(progress.ptr()))
        throw py::type_error(
            "progress is not callable; expected a function of (stage, done, total), or None");
    Watch watch;
    std::stop_source stop;
    Progress watched;
    watched.stop = stop.get_token();
    watched.report = [&watch](std::string_view stage, std::uint64_t done, std::uint64_t total) {
        const std::lock_guard lock(watch.mutex);
        watch.stage = stage;
        watch.done = done;
        watch.total = total;
        watch.has_news = true;
    };
    std::exception_ptr raised;  // an exception of Python
    {
        std::jthread worker([&] {
            std::exception_ptr thrown;
            try {
                work(watched);
            } catch (...) {
                thrown = std::current_exception();
            }
            const std::lock_guard lock(watch.mutex);
            watch.thrown = thrown;
            watch.is_done = true;
            watch.change.notify_all();
        });
        for (bool is_done = false; !is_done;) {
            {
                const py::gil_scoped_release released;
                std::unique_lock lock(watch.mutex);
                is_done = watch.change.wait_for(lock, between_looks, [&] { return watch.is_done; });
            }
            if (raised) continue;
            try {
                if (PyErr_CheckSignals() != 0) throw py::error_already_set();
                tell(watch, progress);
            } catch (...) {
                raised = std::current_exception();
                stop.request_stop();
            }
        }
    }
    if (raised) std::rethrow_exception(raised);
    if (watch.thrown) std::rethrow_exception(watch.thrown);
}

void warn(const std::vector<std::string>& warnings) {
    for (const std::string& text : warnings)
        if (PyErr_WarnEx(warning_class, text.c_str(), 1) != 0) throw py::error_already_set();
}

Turn::Turn(std::timed_mutex& mutex, const Progress& progress) : lock_(mutex, std::defer_lock) {
    while (!lock_.try_lock_for(between_looks) && !progress.stop.stop_requested()) {
    }
}

void add_errors(py::module_& module) {
    py::register_exception_translator([](std::exception_ptr exception) {
        try {
            if (exception) std::rethrow_exception(exception);
        } catch (const std::bad_alloc& failure) {
            PyErr_SetString(PyExc_MemoryError, exception_message(failure).c_str());
        }
    });
    const auto added = [&module](const char* name, const char* text, PyObject* base) {
        PyObject* made =
            PyErr_NewExceptionWithDoc((std::string("haarfield.") + name).c_str(), text, base, nullptr);
        if (made == nullptr) throw py::error_already_set();
        module.attr(name) = py::reinterpret_steal<py::object>(made);
        return made;
    };
    error_class = added("Error",
                        "An error of haarfield: bad files, scenes and meshes, and work that failed.\n\n"
                        "where  the file, or the place in a scene; may be empty.\n"
                        "what   what was found, and what was expected.",
                        PyExc_RuntimeError);
    warning_class =
        added("Warning", "Parts of scenes and meshes that were repaired or ignored.", PyExc_UserWarning);
}

}  // namespace haarfield::python
