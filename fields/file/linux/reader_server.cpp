#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <new>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "fields/base/sanitizers.h"
#include "fields/file/linux/reader_channel.h"
#include "fields/file/linux/reader_sandbox.h"
#include "fields/file/reader_program.h"

namespace haarfield {
namespace {

using Clock = std::chrono::steady_clock;

/// A request with its descriptors.
struct Request {
    ReaderRequest head;
    std::string details;
    int file = -1, answer = -1, outcome = -1;

    void close_all() {
        for (int* descriptor : {&file, &answer, &outcome}) {
            if (*descriptor >= 0) ::close(*descriptor);
            *descriptor = -1;
        }
    }
};

/// Receives a request. False at the end of the socket.
bool receive(int socket, Request& request) {
    std::vector<char> bytes(sizeof(ReaderRequest) + longest_details);
    iovec place{bytes.data(), bytes.size()};
    alignas(cmsghdr) char control[CMSG_SPACE(3 * sizeof(int))];
    msghdr message{};
    message.msg_iov = &place;
    message.msg_iovlen = 1;
    message.msg_control = control;
    message.msg_controllen = sizeof control;
    ssize_t size = 0;
    do size = recvmsg(socket, &message, MSG_CMSG_CLOEXEC);
    while (size < 0 && errno == EINTR);
    if (size <= 0) return false;
    const cmsghdr* const rights = CMSG_FIRSTHDR(&message);
    if (rights && rights->cmsg_type == SCM_RIGHTS && rights->cmsg_len == CMSG_LEN(3 * sizeof(int))) {
        int descriptors[3];
        std::memcpy(descriptors, CMSG_DATA(rights), sizeof descriptors);
        request.file = descriptors[0];
        request.answer = descriptors[1];
        request.outcome = descriptors[2];
    }
    if (static_cast<std::size_t>(size) >= sizeof(ReaderRequest)) {
        std::memcpy(&request.head, bytes.data(), sizeof(ReaderRequest));
        request.details.assign(bytes.data() + sizeof(ReaderRequest),
                               static_cast<std::size_t>(size) - sizeof(ReaderRequest));
    }
    return true;
}

/// Appends to a file. Throws std::bad_alloc on failure.
void write_all(int descriptor, std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t count = ::write(descriptor, bytes.data(), bytes.size());
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) throw std::bad_alloc();
        bytes.remove_prefix(static_cast<std::size_t>(count));
    }
}

/// Reads one file and ends the process.
[[noreturn]] void work(const Request& request, std::span<const ReaderTask> tasks) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, nullptr);
    limit_this_process({request.head.memory, request.head.answer, request.head.seconds});
    const std::string_view name(request.head.task.data());
    const auto task =
        std::find_if(tasks.begin(), tasks.end(), [&](const ReaderTask& known) { return known.name == name; });
    const bool has_folder = task != tasks.end() && task->folder;
    if (!sandbox_this_process(has_folder ? task->folder(request.details) : "") &&
        !request.head.may_be_unsandboxed)
        _exit(static_cast<int>(WorkerExit::unsandboxed));
    const auto refuse = [&](const std::string& what) {
        if (ftruncate(request.answer, 0) == 0 && lseek(request.answer, 0, SEEK_SET) == 0)
            write_all(request.answer, what);
        _exit(static_cast<int>(WorkerExit::refused));
    };
    try {
        if (task == tasks.end()) refuse("there is no reader for this kind of file");
        const Result<MappedFile> file = mapped_file(request.file, "", task->pages);
        if (!file) refuse(file.error().what);
        // Small pieces are buffered, so that a list of names does not need a thousand system calls.
        std::string gathered;
        ByteSink answer([&](std::string_view bytes) {
            constexpr std::size_t piece = 1 << 16;
            if (bytes.size() < piece) gathered += bytes;
            if (bytes.size() >= piece || gathered.size() >= piece) {
                write_all(request.answer, gathered);
                gathered.clear();
            }
            if (bytes.size() >= piece) write_all(request.answer, bytes);
        });
        const Result<Done> read = task->read(file->bytes, request.details, answer);
        if (!read) refuse(read.error().what);
        write_all(request.answer, gathered);
        _exit(static_cast<int>(WorkerExit::done));
    } catch (const std::bad_alloc&) {
        refuse("needs more memory than a file of its size may use");
    } catch (const std::exception& error) {  // libraries throw for some damaged files
        refuse(error.what());
    }
    std::abort();  // not reached
}

struct Worker {
    pid_t id;
    int outcome;
    int patience;                      ///< Consecutive checks that may find it asleep, > 0.
    std::uint64_t processor_time = 0;  ///< Total at the last check. [clock ticks]
    int slept = 0;                     ///< Consecutive checks that found it asleep.
    bool stalled = false;
};

void tell(int outcome, int status, bool stalled) {
    const ReaderOutcome told{status, stalled};
    [[maybe_unused]] const ssize_t written = ::write(outcome, &told, sizeof told);
    ::close(outcome);
}

/// Detaches the server from the terminal, so that neither Ctrl-C nor a hangup ends it, but only the end of
/// its client. Discards its output, including that of libraries. Returns a descriptor that signals the end of
/// a worker.
int prepare_server() {
    setsid();  // no controlling terminal, so nothing can be typed into the user's
    for (const int ignored : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE, SIGXFSZ}) signal(ignored, SIG_IGN);
    // Sanitizers report to the standard error.
    if (const int nothing = has_shadow_memory ? -1 : ::open("/dev/null", O_RDWR | O_CLOEXEC); nothing >= 0) {
        for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(nothing, standard);
        if (nothing > STDERR_FILENO) ::close(nothing);
    }
    sigset_t children;
    sigemptyset(&children);
    sigaddset(&children, SIGCHLD);
    signal(SIGCHLD, SIG_DFL);
    sigprocmask(SIG_BLOCK, &children, nullptr);
    return signalfd(-1, &children, SFD_CLOEXEC | SFD_NONBLOCK);
}

/// Reports workers that have ended.
void collect(std::vector<Worker>& workers) {
    int status = 0;
    for (pid_t id = 0; (id = waitpid(-1, &status, WNOHANG)) > 0;) {
        const auto worker = std::find_if(workers.begin(), workers.end(),
                                         [id](const Worker& known) { return known.id == id; });
        if (worker == workers.end()) continue;
        tell(worker->outcome, status, worker->stalled);
        workers.erase(worker);
    }
}

/// Reads the state of a thread from its `stat`, and adds its processor time [clock ticks]. False on failure.
bool read_status(const std::filesystem::path& file, char& state, std::uint64_t& ticks) {
    std::ifstream stream(file);
    const std::string text((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
    const std::size_t name_end = text.rfind(") ");  // a name may contain anything
    if (name_end == text.npos) return false;
    std::istringstream fields(text.substr(name_end + 2));
    constexpr int before_times = 10;
    std::string unused;
    std::uint64_t user = 0, system = 0;
    fields >> state;
    for (int i = 0; i < before_times; ++i) fields >> unused;
    fields >> user >> system;
    ticks += user + system;
    return bool(fields);
}

/// True if all threads of a worker sleep and have used no processor time since the last check. A thread that
/// waits for a processor or a disk does not count as asleep.
bool is_asleep(Worker& worker) {
    const std::uint64_t before = worker.processor_time;
    const std::string tasks = "/proc/" + std::to_string(worker.id) + "/task";
    std::uint64_t ticks = 0;
    bool sleeps = true;
    std::error_code code;
    for (std::filesystem::directory_iterator entry(tasks, code), end; !code && entry != end;
         entry.increment(code)) {
        char state = 0;
        if (!read_status(entry->path() / "stat", state, ticks) || state != 'S') sleeps = false;
    }
    worker.processor_time = ticks;
    return sleeps && !code && ticks == before;
}

/// The reader process for all other tasks.
class OtherReader {
public:
    explicit OtherReader(const std::filesystem::path& program) : program_(program) {}

    /// Passes a request on. Starts the program for the first request, and again if it has ended.
    bool forward(const Request& request) {
        for (int tries = 0; tries < 2; ++tries) {
            if (socket_ < 0) socket_ = spawned_reader(program_);
            if (socket_ < 0) return false;
            if (send_request(socket_, request.head, request.details,
                             {request.file, request.answer, request.outcome}))
                return true;
            close();
        }
        return false;
    }
    void close() {
        if (socket_ >= 0) ::close(socket_);
        socket_ = -1;
    }

private:
    std::filesystem::path program_;
    int socket_ = -1;
};

constexpr int checks_per_second = 4;

/// Kills workers that were asleep for too many checks.
void end_stalled(std::vector<Worker>& workers) {
    for (Worker& worker : workers) {
        worker.slept = is_asleep(worker) ? worker.slept + 1 : 0;
        if (worker.slept < worker.patience || worker.stalled) continue;
        worker.stalled = true;
        ::kill(worker.id, SIGKILL);
    }
}

/// Waits for a request or the end of a worker. Checks for stalled workers at regular intervals. False if the
/// system call fails.
bool wait_for_events(std::span<pollfd> ready, std::vector<Worker>& workers, Clock::time_point& next_check) {
    constexpr auto interval = std::chrono::milliseconds(1000 / checks_per_second);
    int wait = -1;
    if (!workers.empty()) {
        const Clock::time_point now = Clock::now();
        if (now >= next_check) {
            end_stalled(workers);
            next_check = now + interval;
        }
        wait = int(std::chrono::ceil<std::chrono::milliseconds>(next_check - now).count());
    }
    if (::poll(ready.data(), ready.size(), wait) >= 0) return true;
    for (pollfd& one : ready) one.revents = 0;
    return errno == EINTR;
}

/// Serves requests until the other end of the socket is closed.
[[noreturn]] void serve(int socket, std::span<const ReaderTask> tasks,
                        const std::filesystem::path& other_program) {
    const int ended = prepare_server();
    OtherReader other(other_program);
    std::vector<Worker> workers;
    Clock::time_point next_check{};
    while (true) {
        pollfd ready[]{{socket, POLLIN, 0}, {ended, POLLIN, 0}};
        if (!wait_for_events(ready, workers, next_check)) break;
        if (ready[1].revents & POLLIN) {
            signalfd_siginfo unused;
            while (::read(ended, &unused, sizeof unused) > 0) {
            }
        }
        collect(workers);
        if (!(ready[0].revents & (POLLIN | POLLHUP | POLLERR))) continue;
        Request request;
        if (!receive(socket, request)) break;
        if (request.outcome < 0) continue;
        const std::string_view name(request.head.task.data());
        const bool is_known =
            std::ranges::any_of(tasks, [&](const ReaderTask& task) { return task.name == name; });
        if (!is_known && !other_program.empty()) {
            if (!other.forward(request)) tell(std::exchange(request.outcome, -1), -1, false);
            request.close_all();
            continue;
        }
        const pid_t worker = fork();
        if (worker == 0) {
            ::close(socket);
            other.close();  // workers read untrusted files: no requests of theirs
            for (const Worker& running : workers) ::close(running.outcome);
            // Only the server reports the end of this worker to the client.
            ::close(request.outcome);
            work(request, tasks);
        }
        if (worker < 0) {
            tell(request.outcome, -1, false);
        } else {
            constexpr double shortest = 5, longest = 1e6;  // [s]
            const double patience = std::clamp(request.head.seconds, shortest, longest);
            workers.push_back({worker, request.outcome, int(patience * checks_per_second)});
        }
        request.outcome = -1;
        request.close_all();
    }
    for (const Worker& worker : workers) ::kill(worker.id, SIGKILL);
    _exit(0);
}

}  // namespace

void serve_reader_process(int socket, std::span<const ReaderTask> tasks) {
    serve(socket, tasks, {});
}

int run_reader_program(const char* name, std::span<const ReaderTask> tasks,
                       const std::filesystem::path& other_program) {
    constexpr int socket = 3;  // see spawned_reader
    struct stat status {};
    if (fstat(socket, &status) == 0 && S_ISSOCK(status.st_mode)) serve(socket, tasks, other_program);
    std::fprintf(stderr,
                 "%s reads files for programs that use haarfield's libraries; do not start it directly\n",
                 name);
    return 2;
}

}  // namespace haarfield
