#pragma once
/// A program that we run and listen to.

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace haarfield {

/// A running child whose stderr we read; its stdin and stdout are /dev/null. Ended, if need be, and waited
/// for when it goes out of scope; ended by the system, too, if this process or the thread that started it
/// ends.
class ChildProcess {
public:
    ChildProcess() = default;
    ~ChildProcess();
    ChildProcess(const ChildProcess&) = delete;
    ChildProcess& operator=(const ChildProcess&) = delete;

    /// program   a path, or a name to be looked up in PATH.
    /// folder    its working directory.
    /// returns   an error number (ENOENT: no such program), or 0.
    int start(const std::string& program, const std::vector<std::string>& arguments,
              const std::filesystem::path& folder);

    /// Reads what there is, waiting some 20 ms for it; false at the end of what it says.
    bool read_some(std::string& text) const;

    /// Waits for its end: its status as waitpid has it; -1 if there is none.
    int wait();

private:
    pid_t id_ = -1;
    int log_ = -1;
};

}  // namespace haarfield
