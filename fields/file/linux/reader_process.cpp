#include "fields/file/reader_process.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <mutex>
#include <thread>

#include "fields/base/sanitizers.h"
#include "fields/file/linux/reader_channel.h"
#include "fields/file/this_process.h"

namespace haarfield {
namespace {

/// A file descriptor that is closed at the end of its scope.
struct Descriptor {
    int number = -1;

    explicit Descriptor(int given) : number(given) {}
    ~Descriptor() { close(); }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;

    void close() {
        if (number >= 0) ::close(number);
        number = -1;
    }
};

constexpr const char* variable = "HAARFIELD_READER";

/// The reader process of this process.
struct Connection {
    std::mutex looking;
    bool looked_for = false;
    // ThreadSanitizer builds have no reader process
    std::atomic<bool> may_be_unsandboxed = is_thread_sanitized;
    std::string failure;  ///< The error if a program that was named explicitly cannot be run.
    int socket = -1;      ///< -1: there is no reader process.
};

Connection& connection() {
    static Connection made;
    return made;
}

Error system_error(const std::string& where, const char* action, int number) {
    return {where, fmt::format("cannot {}: {}", action, std::strerror(number))};
}

/// Tests whether all other threads sleep, so that none of them holds a lock.
bool others_sleep() {
    const std::string own = std::to_string(gettid());
    std::error_code code;
    for (const auto& entry : std::filesystem::directory_iterator("/proc/self/task", code)) {
        if (entry.path().filename() == own) continue;
        std::ifstream file(entry.path() / "stat");
        const std::string status((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
        const std::size_t name = status.rfind(") ");  // a name may contain anything
        if (name == std::string::npos || status.compare(name + 2, 1, "S") != 0) return false;
    }
    return !code;
}

/// Returns the folder of the executable or shared library that holds this code.
std::filesystem::path own_folder() {
    Dl_info own{};
    if (dladdr(reinterpret_cast<const void*>(&connection), &own) == 0 || !own.dli_fname) return {};
    std::error_code ignored;
    return std::filesystem::absolute(own.dli_fname, ignored).parent_path();
}

/// Returns the executable that HAARFIELD_READER names, or else haarfield-reader next to the running
/// executable, next to this library or where it was installed. Empty if there is none.
std::filesystem::path found_program(bool& is_named) {
    const char* const named = std::getenv(variable);
    is_named = named && *named;
    if (named) return named;
    for (const std::filesystem::path& folder :
         {running_program().parent_path(), own_folder(), std::filesystem::path(HAARFIELD_PROGRAM_FOLDER)}) {
        std::filesystem::path program = folder / "haarfield-reader";
        if (!folder.empty() && ::access(program.c_str(), X_OK) == 0) return program;
    }
    return {};
}

int memory_file() {
    return memfd_create("haarfield", MFD_CLOEXEC | MFD_ALLOW_SEALING);
}

/// Reads the outcome of a worker. False if the reader process itself has ended.
bool receive(int pipe, ReaderOutcome& outcome) {
    ssize_t size = 0;
    do size = ::read(pipe, &outcome, sizeof outcome);
    while (size < 0 && errno == EINTR);
    return size == sizeof outcome;
}

/// Returns the error message for a worker that gave no answer.
std::string failure_of(const ReaderOutcome& outcome, const ReaderLimits& limits) {
    if (outcome.stalled) return "its reader stopped responding: the file is damaged";
    if (WIFSIGNALED(outcome.status) && WTERMSIG(outcome.status) == SIGXCPU)
        return fmt::format("took longer than {:.0f} s of processor time to read", limits.seconds);
    if (WIFEXITED(outcome.status) && WEXITSTATUS(outcome.status) == int(WorkerExit::unsandboxed))
        return fmt::format("its reader cannot be sandboxed on this system; {}", unsandboxed_remedy);
    if (outcome.status == -1) return "no process could be started to read it";
    if (WIFSIGNALED(outcome.status))
        return fmt::format("its reader ended by signal {} ({}): the file is damaged",
                           WTERMSIG(outcome.status), strsignal(WTERMSIG(outcome.status)));
    return fmt::format("its reader ended (code {}): the file is damaged", WEXITSTATUS(outcome.status));
}

}  // namespace

ReaderLimits reader_limits(std::uint64_t file_bytes, double memory_per_byte) {
    constexpr double least_memory = 1 << 30, least_seconds = 10, bytes_per_second = 1e6;
    const double bytes = static_cast<double>(file_bytes),
                 all_memory = double(sysconf(_SC_PHYS_PAGES)) * double(sysconf(_SC_PAGESIZE));
    const auto memory =
        static_cast<std::uint64_t>(std::min(least_memory + memory_per_byte * bytes, all_memory));
    return {memory, memory / 2, least_seconds + bytes / bytes_per_second};
}

Result<Done> fork_reader_process(std::span<const ReaderTask> tasks) {
    Connection& made = connection();
    const std::lock_guard lock(made.looking);
    if (made.socket >= 0 || std::getenv(variable)) return Done{};
    if (is_thread_sanitized) return Error{"", "ThreadSanitizer does not support fork"};
    // Some libraries start threads when they are loaded. These soon sleep.
    for (int tries = 0; !others_sleep(); ++tries) {
        constexpr int most_tries = 50;
        if (tries == most_tries) return Error{"", "other threads are running"};
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0)
        return system_error("", "create a socket", errno);
    const pid_t server = fork();
    if (server < 0) {
        const int number = errno;
        ::close(ends[0]);
        ::close(ends[1]);
        return system_error("", "create a process", number);
    }
    if (server == 0) {
        ::close(ends[0]);
        serve_reader_process(ends[1], tasks);
    }
    ::close(ends[1]);
    made.socket = ends[0];
    made.looked_for = true;
    return Done{};
}

void allow_unsandboxed_readers() {
    connection().may_be_unsandboxed = true;
}

Result<bool> reads_apart() {
    Connection& made = connection();
    const std::lock_guard lock(made.looking);
    if (!made.looked_for && !is_thread_sanitized) {
        made.looked_for = true;
        bool is_named = false;
        const std::filesystem::path program = found_program(is_named);
        if (!program.empty()) made.socket = spawned_reader(program);
        if (made.socket < 0 && is_named)
            made.failure =
                fmt::format("cannot be run: {}; expected HAARFIELD_READER to name haarfield-reader",
                            std::strerror(errno));
        if (!made.failure.empty()) made.failure = program.string() + ": " + made.failure;
    }
    if (!made.failure.empty()) return Error{"", made.failure};
    if (made.socket < 0 && !made.may_be_unsandboxed)
        return Error{"",
                     fmt::format("there is no reader process for untrusted files (haarfield-reader was not "
                                 "found); {}",
                                 unsandboxed_remedy)};
    return made.socket >= 0;
}

Result<MappedFile> read_apart(std::string_view task, int descriptor, std::string_view details,
                              const ReaderLimits& limits, const std::string& where) {
    ReaderRequest head;
    assert(task.size() < head.task.size());
    std::copy(task.begin(), task.end(), head.task.begin());
    head.memory = limits.memory;
    head.answer = limits.answer;
    head.seconds = limits.seconds;
    head.may_be_unsandboxed = connection().may_be_unsandboxed;
    if (details.size() > longest_details) return Error{where, "its name is too long"};
    const Descriptor answer(memory_file());
    int ends[2];
    if (answer.number < 0 || pipe2(ends, O_CLOEXEC) != 0)
        return system_error(where, "allocate memory for its content", errno);
    const Descriptor told(ends[0]);
    Descriptor telling(ends[1]);
    if (!send_request(connection().socket, head, details, {descriptor, answer.number, telling.number}))
        return system_error(where, "reach the reader process", errno);
    telling.close();
    ReaderOutcome outcome;
    if (!receive(told.number, outcome)) return Error{where, "the reader process has ended"};
    const bool has_ended = outcome.status != -1 && WIFEXITED(outcome.status);
    const bool is_done = has_ended && WEXITSTATUS(outcome.status) == int(WorkerExit::done);
    const bool is_refused = has_ended && WEXITSTATUS(outcome.status) == int(WorkerExit::refused);
    if (!is_done && !is_refused) return Error{where, failure_of(outcome, limits)};
    Result<MappedFile> mapped = mapped_file(answer.number, where);
    if (!mapped || is_done) return mapped;
    constexpr std::size_t longest_message = 4096;
    return Error{where, std::string(mapped->bytes.substr(0, longest_message))};
}

Result<MappedFile> read_apart(std::string_view task, std::string_view bytes, std::string_view details,
                              const ReaderLimits& limits, const std::string& where) {
    const Descriptor file(memory_file());
    if (file.number < 0) return system_error(where, "allocate memory for it", errno);
    for (std::string_view rest = bytes; !rest.empty();) {
        const ssize_t count = ::write(file.number, rest.data(), rest.size());
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return system_error(where, "allocate memory for it", errno);
        rest.remove_prefix(static_cast<std::size_t>(count));
    }
    // The worker gets this descriptor. The seals prevent it from using the file as additional memory.
    constexpr int seals = F_SEAL_SEAL | F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE;
    if (fcntl(file.number, F_ADD_SEALS, seals) != 0) return system_error(where, "seal a copy of it", errno);
    return read_apart(task, file.number, details, limits, where);
}

}  // namespace haarfield
