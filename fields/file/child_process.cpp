#include "fields/file/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>

#include "fields/file/process_time.h"
#include "fields/file/this_process.h"

namespace haarfield {
namespace {

/// Runs in the child between fork and exec, and must not acquire a lock that another thread may hold. If exec
/// fails, writes the error number to `failure`.
[[noreturn]] void become(const char* program, char* const* arguments, const char* folder,
                         const ChildSandbox* sandbox, pid_t parent, int log, int failure) {
    // The parent may be killed before it can end the child.
    end_with_parent();
    for (const int ignored : {SIGPIPE, SIGXFSZ}) ::signal(ignored, SIG_DFL);
    sigset_t none;
    sigemptyset(&none);
    ::sigprocmask(SIG_SETMASK, &none, nullptr);
    const int nothing = ::open("/dev/null", O_RDWR | O_CLOEXEC);
    if (::getppid() == parent && nothing >= 0 && ::dup2(nothing, STDIN_FILENO) >= 0 &&
        ::dup2(nothing, STDOUT_FILENO) >= 0 && ::dup2(log, STDERR_FILENO) >= 0 && ::chdir(folder) == 0) {
        if (sandbox && !sandbox->enter())
            errno = EPERM;
        else
            ::execvp(program, arguments);
    }
    const int number = errno;
    [[maybe_unused]] const ssize_t told = ::write(failure, &number, sizeof number);
    ::_exit(127);
}

}  // namespace

ChildProcess::~ChildProcess() {
    if (log_ >= 0) ::close(log_);
    if (id_ > 0) {
        ::kill(id_, SIGKILL);
        wait();
    }
}

int ChildProcess::start(const std::string& program, const std::vector<std::string>& arguments,
                        const std::filesystem::path& folder, const ChildSandbox* sandbox) {
    int ends[2], failure[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) return errno;
    if (::pipe2(failure, O_CLOEXEC) != 0) {
        const int number = errno;
        ::close(ends[0]);
        ::close(ends[1]);
        return number;
    }
    std::vector<char*> argv{const_cast<char*>(program.c_str())};
    for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    const pid_t parent = getpid();
    id_ = fork();
    if (id_ == 0) become(program.c_str(), argv.data(), folder.c_str(), sandbox, parent, ends[1], failure[1]);
    int number = id_ < 0 ? errno : 0;
    ::close(ends[1]);
    ::close(failure[1]);
    log_ = ends[0];
    if (id_ > 0) {
        ssize_t size = 0;
        do size = ::read(failure[0], &number, sizeof number);
        while (size < 0 && errno == EINTR);
        if (size == sizeof number)
            wait();
        else
            number = 0;  // exec succeeded and closed the pipe
    }
    ::close(failure[0]);
    return number;
}

bool ChildProcess::read_some(std::string& text) const {
    constexpr int milliseconds = 20;
    pollfd ready{log_, POLLIN, 0};
    if (::poll(&ready, 1, milliseconds) <= 0) return true;
    char buffer[4096];
    const ssize_t count = ::read(log_, buffer, sizeof buffer);
    if (count > 0) text.append(buffer, static_cast<std::size_t>(count));
    return count > 0 || (count < 0 && errno == EINTR);
}

std::optional<double> ChildProcess::processor_seconds() const {
    return haarfield::processor_seconds(id_);
}

int ChildProcess::wait() {
    int status = -1;
    while (::waitpid(id_, &status, 0) < 0 && errno == EINTR) {
    }
    id_ = -1;
    return status;
}

}  // namespace haarfield
