#pragma once
/// A child process whose stderr is read.

#include "fields/file/child_sandbox.h"

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace haarfield {

/// A running child process. Its stderr can be read; its stdin and stdout are /dev/null. The destructor kills
/// the child if it still runs, and waits for it. The kernel kills the child if this process or the thread
/// that started it ends.
class ChildProcess {
public:
    ChildProcess() = default;
    ~ChildProcess();
    ChildProcess(const ChildProcess&) = delete;
    ChildProcess& operator=(const ChildProcess&) = delete;

    /// Starts a program.
    ///
    /// program   a path, or a name to be looked up in PATH.
    /// folder    the working directory of the program.
    /// sandbox   restricts the program; null: none.
    /// returns   0, or an error number (ENOENT: the program does not exist; EPERM: the system refuses the
    ///           sandbox).
    int start(const std::string& program, const std::vector<std::string>& arguments,
              const std::filesystem::path& folder, const ChildSandbox* sandbox = nullptr);

    /// Appends available output to `text`; waits up to 20 ms for it. Returns false at the end of the output.
    bool read_some(std::string& text) const;

    /// Returns the processor time of the child and its descendants. [s] None if the system does not report
    /// it.
    std::optional<double> processor_seconds() const;

    /// Waits until the child ends. Returns its status as waitpid does, or -1 if there is no child.
    int wait();

private:
    pid_t id_ = -1;
    int log_ = -1;
};

}  // namespace haarfield
