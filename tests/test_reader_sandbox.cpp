#include "fields/file/linux/reader_sandbox.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <functional>
#include <thread>

#include "fields/base/sanitizers.h"
#include "tests/fixtures/test_folder.h"

namespace haarfield {
namespace {

constexpr int killed = -1, allowed = 0;

/// An operation that is attempted in the sandbox.
struct Attempt {
    const char* name;
    int expected;                  ///< The error number, `allowed` or `killed`.
    std::function<long()> action;  ///< Returns what the system call returns.
};

/// Performs an attempt in a sandboxed process. Returns the error number, `allowed` or `killed`.
int outcome(const Attempt& attempt, const std::string& folder) {
    const pid_t child = fork();
    if (child == 0) {
        if (!sandbox_this_process(folder)) _exit(255);
        _exit(attempt.action() >= 0 ? allowed : errno);
    }
    int status = 0;
    waitpid(child, &status, 0);
    if (WIFSIGNALED(status)) return WTERMSIG(status) == SIGSYS ? killed : 1000 + WTERMSIG(status);
    return WEXITSTATUS(status);
}

std::string text_of_outcome(int value) {
    if (value == killed) return "killed";
    return value == allowed ? "allowed" : std::strerror(value);
}

template <class... Arguments>
std::function<long()> call(long number, Arguments... arguments) {
    return [=] { return syscall(number, arguments...); };
}

/// True if the kernel restricts access to files by name.
bool has_landlock() {
    constexpr unsigned version_flag = 1;
    return syscall(SYS_landlock_create_ruleset, nullptr, 0, version_flag) > 0;
}

TEST(ReaderSandbox, ForbiddenOperationsFailOrEndTheReader) {
    const TestFolder folder;
    std::filesystem::create_directory(folder / "below");
    write_text(folder / "below/file", "text");
    write_text(folder / "outside", "text");
    const std::string below = (folder / "below").string(), inside = below + "/file",
                      outside = (folder / "outside").string();
    const char* const file = inside.c_str();
    const long parent = getpid();  // of the sandboxed process
    const std::string memory = fmt::format("/proc/{}/mem", parent),
                      environment = fmt::format("/proc/{}/environ", parent);
    const int open_file = open(file, O_RDONLY | O_CLOEXEC);
    ASSERT_GE(open_file, 0);
    static rlimit limit{};
    static siginfo_t info{};
    info.si_code = SI_QUEUE;
    const int denied = has_landlock() ? EACCES : allowed;
    const auto opened = [](const char* name, int flags) {
        return call(SYS_openat, AT_FDCWD, name, flags, 0600);
    };
    std::vector<Attempt> attempts{
        // files
        {"open a file in the folder", allowed, opened(file, O_RDONLY)},
        {"open a file outside", denied, opened(outside.c_str(), O_RDONLY)},
        {"open /etc/shadow", has_landlock() || geteuid() == 0 ? denied : EACCES,
         opened("/etc/shadow", O_RDONLY)},
        {"open /proc/PARENT/mem", denied, opened(memory.c_str(), O_RDONLY)},
        {"open /proc/PARENT/environ", denied, opened(environment.c_str(), O_RDONLY)},
        {"open for writing", EPERM, opened(file, O_WRONLY)},
        {"open for reading and writing", EPERM, opened(file, O_RDWR)},
        {"create", EPERM, opened((below + "/new").c_str(), O_WRONLY | O_CREAT)},
        {"open an unnamed file", EPERM, opened(below.c_str(), O_RDWR | O_TMPFILE)},
        {"open /dev/tty", denied, opened("/dev/tty", O_RDONLY)},
        {"openat2", ENOSYS, call(SYS_openat2, AT_FDCWD, file, nullptr, 0)},
        {"open_by_handle_at", EPERM, call(SYS_open_by_handle_at, AT_FDCWD, nullptr, O_RDWR)},
        {"fchmod", EPERM, call(SYS_fchmod, open_file, 0777)},
        {"fchmodat", EPERM, call(SYS_fchmodat, AT_FDCWD, file, 0777)},
        {"fchmodat2", EPERM, call(452, AT_FDCWD, file, 0777, 0)},
        {"fchown", EPERM, call(SYS_fchown, open_file, 1, 1)},
        {"fchownat", EPERM, call(SYS_fchownat, AT_FDCWD, file, 1, 1, 0)},
        {"setxattr", EPERM, call(SYS_setxattr, file, "user.x", "y", 1, 0)},
        {"lsetxattr", EPERM, call(SYS_lsetxattr, file, "user.x", "y", 1, 0)},
        {"fsetxattr", EPERM, call(SYS_fsetxattr, open_file, "user.x", "y", 1, 0)},
        {"removexattr", EPERM, call(SYS_removexattr, file, "user.x")},
        {"utimensat", EPERM, call(SYS_utimensat, AT_FDCWD, file, nullptr, 0)},
        {"truncate", EPERM, call(SYS_truncate, file, 0)},
        {"unlinkat", EPERM, call(SYS_unlinkat, AT_FDCWD, file, 0)},
        {"renameat2", EPERM, call(SYS_renameat2, AT_FDCWD, file, AT_FDCWD, outside.c_str(), 0)},
        {"linkat", EPERM, call(SYS_linkat, AT_FDCWD, file, AT_FDCWD, "other", 0)},
        {"symlinkat", EPERM, call(SYS_symlinkat, file, AT_FDCWD, "other")},
        {"mkdirat", EPERM, call(SYS_mkdirat, AT_FDCWD, "other", 0700)},
        {"mknodat", EPERM, call(SYS_mknodat, AT_FDCWD, "other", S_IFREG | 0600, 0)},
        {"memfd_create", EPERM, call(SYS_memfd_create, "x", 0)},
        {"ioctl TIOCSTI", EPERM, call(SYS_ioctl, 0, 0x5412, "x")},
        {"fcntl F_SETOWN", EPERM, call(SYS_fcntl, open_file, F_SETOWN, parent)},
        {"mount", EPERM, call(SYS_mount, "x", "/", "tmpfs", 0, nullptr)},
        {"fsopen", EPERM, call(430, "tmpfs", 0)},
        {"open_tree", EPERM, call(428, AT_FDCWD, "/", 0)},
        {"chroot", EPERM, call(SYS_chroot, "/")},
        {"unshare", EPERM, call(SYS_unshare, CLONE_NEWUSER)},
        {"io_uring_setup", EPERM, call(425, 1, nullptr)},
        // memory
        {"mmap for execution", EPERM,
         call(SYS_mmap, nullptr, 4096, PROT_READ | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0)},
        {"mmap for data", allowed,
         [] {
             return mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) ==
                            MAP_FAILED
                        ? -1L
                        : 0L;
         }},
        {"shmget", EPERM, call(SYS_shmget, 0x7777, 4096, 01666)},
        {"msgget", EPERM, call(SYS_msgget, 0x7777, 01666)},
        {"semget", EPERM, call(SYS_semget, 0x7777, 1, 01666)},
        {"mq_open", EPERM, call(SYS_mq_open, "haarfield", O_RDWR | O_CREAT, 0600, nullptr)},
        {"mq_unlink", EPERM, call(SYS_mq_unlink, "haarfield")},
        {"process_vm_readv", EPERM, call(SYS_process_vm_readv, parent, nullptr, 0, nullptr, 0, 0)},
        {"process_vm_writev", EPERM, call(SYS_process_vm_writev, parent, nullptr, 0, nullptr, 0, 0)},
        // network
        {"socket", EPERM, call(SYS_socket, 2, 1, 0)},
        {"socketpair", EPERM, call(SYS_socketpair, 1, 1, 0, nullptr)},
        // processes
        {"fork by clone", EPERM, call(SYS_clone, SIGCHLD, 0, 0, 0, 0)},
        {"clone3", ENOSYS, call(SYS_clone3, nullptr, 0)},
        {"execve", killed, call(SYS_execve, "/bin/true", nullptr, nullptr)},
        {"execveat", killed, call(SYS_execveat, AT_FDCWD, "/bin/true", nullptr, nullptr, 0)},
        {"ptrace", killed, call(SYS_ptrace, 0, 0, 0, 0)},
        {"kill parent", killed, call(SYS_kill, parent, 0)},
        {"kill all", killed, call(SYS_kill, -1, 0)},
        {"tgkill parent", killed, call(SYS_tgkill, parent, parent, 0)},
        {"tkill parent", killed, call(SYS_tkill, parent, 0)},
        {"rt_sigqueueinfo parent", killed, call(SYS_rt_sigqueueinfo, parent, 0, &info)},
        {"rt_tgsigqueueinfo parent", killed, call(SYS_rt_tgsigqueueinfo, parent, parent, 0, &info)},
        {"pidfd_send_signal", killed, call(424, 0, 0, nullptr, 0)},
        {"pidfd_open", EPERM, call(434, parent, 0)},
        {"tgkill itself", allowed, [] { return syscall(SYS_tgkill, getpid(), gettid(), 0); }},
        {"prlimit64 of parent, read", EPERM, call(SYS_prlimit64, parent, RLIMIT_NOFILE, nullptr, &limit)},
        {"prlimit64 of parent, write", EPERM, call(SYS_prlimit64, parent, RLIMIT_CORE, &limit, nullptr)},
        {"prlimit64 of itself, write", EPERM, call(SYS_prlimit64, 0, RLIMIT_CORE, &limit, nullptr)},
        {"prlimit64 of itself, read", allowed, call(SYS_prlimit64, 0, RLIMIT_NOFILE, nullptr, &limit)},
        {"setpriority of parent", EPERM, call(SYS_setpriority, 0, parent, 0)},
        {"sched_setaffinity of parent", EPERM, call(SYS_sched_setaffinity, parent, 0, nullptr)},
        {"prctl PR_SET_DUMPABLE", EPERM, call(SYS_prctl, 4, 1, 0, 0, 0)},
        {"bpf", EPERM, call(SYS_bpf, 0, nullptr, 0)},
        {"perf_event_open", EPERM, call(SYS_perf_event_open, nullptr, 0, -1, -1, 0)},
        {"keyctl", EPERM, call(SYS_keyctl, 0, 0)},
        {"sethostname", EPERM, call(SYS_sethostname, "x", 0x7fffffff)},
        {"swapon", EPERM, call(SYS_swapon, "/nonexistent", 0)},
        {"settimeofday", EPERM, call(SYS_settimeofday, nullptr, nullptr)},
        {"syslog", EPERM, call(SYS_syslog, 10, nullptr, 0)},
    };
    if (!is_address_sanitized)  // whose threads make further calls
        attempts.push_back({"threads", allowed, [] {
                                std::thread([] {}).join();
                                return 0L;
                            }});
#ifdef __x86_64__
    constexpr long x32 = 0x40000000;
    attempts.push_back({"x32 unlink", killed, call(x32 | SYS_unlink, file)});
    attempts.push_back({"open for writing by its old call", EPERM, call(SYS_open, file, O_WRONLY)});
    attempts.push_back({"creat", EPERM, call(SYS_creat, file, 0600)});
    attempts.push_back({"unlink", EPERM, call(SYS_unlink, file)});
    attempts.push_back({"chmod", EPERM, call(SYS_chmod, file, 0777)});
    attempts.push_back({"chown", EPERM, call(SYS_chown, file, 1, 1)});
    attempts.push_back({"lchown", EPERM, call(SYS_lchown, file, 1, 1)});
    attempts.push_back({"utime", EPERM, call(SYS_utime, file, nullptr)});
    attempts.push_back({"utimes", EPERM, call(SYS_utimes, file, nullptr)});
    attempts.push_back({"futimesat", EPERM, call(SYS_futimesat, AT_FDCWD, file, nullptr)});
    attempts.push_back({"mknod", EPERM, call(SYS_mknod, "other", S_IFREG | 0600, 0)});
    attempts.push_back({"fork", EPERM, call(SYS_fork)});
    attempts.push_back({"vfork", EPERM, call(SYS_vfork)});
#endif
    for (const Attempt& attempt : attempts) {
        const int found = outcome(attempt, below);
        EXPECT_EQ(text_of_outcome(found), text_of_outcome(attempt.expected)) << attempt.name;
    }
    close(open_file);
    EXPECT_EQ(text_of(inside), "text");
}

TEST(ReaderSandbox, NoFileCanBeOpenedWithoutAFolder) {
    if (!has_landlock()) GTEST_SKIP() << "the kernel has no Landlock";
    const TestFolder folder;
    write_text(folder / "file", "text");
    const std::string file = (folder / "file").string();
    EXPECT_EQ(outcome({"", 0, call(SYS_openat, AT_FDCWD, file.c_str(), O_RDONLY)}, ""), EACCES);
}

}  // namespace
}  // namespace haarfield
