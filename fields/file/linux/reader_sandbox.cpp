#include "fields/file/linux/reader_sandbox.h"

#include <fcntl.h>
#include <linux/landlock.h>
#include <sched.h>
#include <seccomp.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <initializer_list>
#include <string>

#include "fields/base/sanitizers.h"

namespace haarfield {
namespace {

void limit(__rlimit_resource resource, rlim_t soft, rlim_t hard) {
    rlimit now{};
    if (getrlimit(resource, &now) != 0) return;
    now.rlim_cur = std::min(soft, now.rlim_max);
    now.rlim_max = std::min(hard, now.rlim_max);
    setrlimit(resource, &now);
}

/// Allows reading below `folder`. Forbids every other access to files by name, to the network, and to
/// processes outside the sandbox. On kernels without Landlock (before 5.13, or built without it), only the
/// filter of system calls applies.
bool restrict_files(const std::string& folder) {
    const long abi = syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
    if (abi < 1) return errno == ENOSYS || errno == EOPNOTSUPP;
    // The rights of each version of the interface. Headers of Debian 12 lack the later ones.
    constexpr std::uint64_t files_1 = (1u << 13) - 1, refer_2 = 1u << 13, truncate_3 = 1u << 14,
                            ioctl_5 = 1u << 15, network_4 = 3, scopes_6 = 3;
    struct {
        std::uint64_t files, network, scopes;
    } handled{files_1, 0, 0};
    if (abi >= 2) handled.files |= refer_2;
    if (abi >= 3) handled.files |= truncate_3;
    if (abi >= 4) handled.network = network_4;
    if (abi >= 5) handled.files |= ioctl_5;
    if (abi >= 6) handled.scopes = scopes_6;
    const std::size_t size = abi >= 6 ? 24 : abi >= 4 ? 16 : 8;
    const int rules = int(syscall(SYS_landlock_create_ruleset, &handled, size, 0));
    if (rules < 0) return false;
    bool good = true;
    if (!folder.empty()) {
        // A folder that cannot be opened contains no readable files.
        if (const int top = open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC); top >= 0) {
            const landlock_path_beneath_attr below{LANDLOCK_ACCESS_FS_READ_FILE | LANDLOCK_ACCESS_FS_READ_DIR,
                                                   top};
            good = syscall(SYS_landlock_add_rule, rules, LANDLOCK_RULE_PATH_BENEATH, &below, 0) == 0;
            close(top);
        }
    }
    good = good && syscall(SYS_landlock_restrict_self, rules, 0) == 0;
    close(rules);
    return good;
}

/// The system calls that readers, their threads and the C library need, with any arguments.
constexpr int allowed[] = {
    SCMP_SYS(read),
    SCMP_SYS(readv),
    SCMP_SYS(pread64),
    SCMP_SYS(write),
    SCMP_SYS(writev),
    SCMP_SYS(lseek),
    SCMP_SYS(close),
    SCMP_SYS(fstat),
    SCMP_SYS(stat),
    SCMP_SYS(lstat),
    SCMP_SYS(newfstatat),
    SCMP_SYS(statx),
    SCMP_SYS(access),
    SCMP_SYS(faccessat),
    SCMP_SYS(faccessat2),
    SCMP_SYS(readlink),
    SCMP_SYS(readlinkat),
    SCMP_SYS(getdents64),
    SCMP_SYS(getcwd),
    SCMP_SYS(ftruncate),
    SCMP_SYS(munmap),
    SCMP_SYS(mremap),
    SCMP_SYS(madvise),
    SCMP_SYS(brk),
    SCMP_SYS(futex),
    SCMP_SYS(sched_yield),
    SCMP_SYS(sched_getaffinity),
    SCMP_SYS(set_robust_list),
    SCMP_SYS(rseq),
    SCMP_SYS(set_tid_address),
    SCMP_SYS(gettid),
    SCMP_SYS(getpid),
    SCMP_SYS(getrandom),
    SCMP_SYS(clock_gettime),
    SCMP_SYS(clock_getres),
    SCMP_SYS(clock_nanosleep),
    SCMP_SYS(nanosleep),
    SCMP_SYS(gettimeofday),
    SCMP_SYS(getrusage),
    SCMP_SYS(sysinfo),
    SCMP_SYS(uname),
    SCMP_SYS(getcpu),
    SCMP_SYS(rt_sigaction),
    SCMP_SYS(rt_sigprocmask),
    SCMP_SYS(rt_sigreturn),
    SCMP_SYS(sigaltstack),
    SCMP_SYS(restart_syscall),
    SCMP_SYS(exit),
    SCMP_SYS(exit_group),
};

/// Adds the rules of the filter. Everything that no rule names gets EPERM.
bool add_rules(scmp_filter_ctx filter) {
    bool good = true;
    const auto allow = [&](int call, std::initializer_list<scmp_arg_cmp> when) {
        good &=
            seccomp_rule_add_array(filter, SCMP_ACT_ALLOW, call, unsigned(when.size()), when.begin()) == 0;
    };
    const auto compare = [](unsigned argument, scmp_compare how, scmp_datum_t a, scmp_datum_t b = 0) {
        return scmp_arg_cmp{argument, how, a, b};
    };
    for (const int call : allowed) allow(call, {});
    constexpr scmp_datum_t not_reading = O_ACCMODE | O_CREAT | O_TRUNC | O_PATH | (O_TMPFILE & ~O_DIRECTORY);
    allow(SCMP_SYS(open), {compare(1, SCMP_CMP_MASKED_EQ, not_reading, 0)});
    allow(SCMP_SYS(openat), {compare(2, SCMP_CMP_MASKED_EQ, not_reading, 0)});
    allow(SCMP_SYS(mmap), {compare(2, SCMP_CMP_MASKED_EQ, PROT_EXEC, 0)});
    allow(SCMP_SYS(mprotect), {compare(2, SCMP_CMP_MASKED_EQ, PROT_EXEC, 0)});
    allow(SCMP_SYS(fcntl), {compare(1, SCMP_CMP_EQ, F_GETFL)});
    allow(SCMP_SYS(fcntl), {compare(1, SCMP_CMP_EQ, F_GETFD)});
    allow(SCMP_SYS(fcntl), {compare(1, SCMP_CMP_EQ, F_SETFD)});
    allow(SCMP_SYS(prlimit64), {compare(0, SCMP_CMP_EQ, 0), compare(2, SCMP_CMP_EQ, 0)});
    constexpr scmp_datum_t thread = CLONE_VM | CLONE_THREAD | CLONE_SIGHAND;
    allow(SCMP_SYS(clone), {compare(0, SCMP_CMP_MASKED_EQ, thread, thread)});
    const auto own = scmp_datum_t(getpid());
    // Signals to other processes kill the reader; abort() signals the reader itself.
    for (const int call : {SCMP_SYS(tgkill), SCMP_SYS(kill)}) {
        allow(call, {compare(0, SCMP_CMP_EQ, own)});
        const scmp_arg_cmp other = compare(0, SCMP_CMP_NE, own);
        good &= seccomp_rule_add_array(filter, SCMP_ACT_KILL_PROCESS, call, 1, &other) == 0;
    }
    for (const int call :
         {SCMP_SYS(ptrace), SCMP_SYS(execve), SCMP_SYS(execveat), SCMP_SYS(tkill), SCMP_SYS(rt_sigqueueinfo),
          SCMP_SYS(rt_tgsigqueueinfo), SCMP_SYS(pidfd_send_signal)})
        good &= seccomp_rule_add_array(filter, SCMP_ACT_KILL_PROCESS, call, 0, nullptr) == 0;
    // The flags of these calls are in memory, which a filter cannot read. Libraries then fall back to older
    // calls.
    for (const int call : {SCMP_SYS(clone3), SCMP_SYS(openat2)})
        good &= seccomp_rule_add_array(filter, SCMP_ACT_ERRNO(ENOSYS), call, 0, nullptr) == 0;
    return good;
}

/// Installs the filter of system calls.
bool filter_calls() {
    const scmp_filter_ctx filter = seccomp_init(SCMP_ACT_ERRNO(EPERM));
    if (!filter) return false;
    seccomp_attr_set(filter, SCMP_FLTATR_ACT_BADARCH, SCMP_ACT_KILL_PROCESS);  // x32 and 32 bit calls
    seccomp_attr_set(filter, SCMP_FLTATR_CTL_OPTIMIZE, 2);
    const bool good = add_rules(filter) && seccomp_load(filter) == 0;
    seccomp_release(filter);
    return good;
}

}  // namespace

void limit_this_process(const ReaderLimits& limits) {
    if (!has_shadow_memory) {
        std::uint64_t pages = 0;
        std::ifstream("/proc/self/statm") >> pages;
        const rlim_t memory =
            pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) + limits.memory - limits.answer;
        limit(RLIMIT_AS, memory, memory);
    }
    limit(RLIMIT_FSIZE, limits.answer, limits.answer);
    const auto seconds = static_cast<rlim_t>(std::ceil(std::clamp(limits.seconds, 1.0, 1e6)));
    limit(RLIMIT_CPU, seconds, seconds + 1);
    limit(RLIMIT_NOFILE, 64, 64);
    limit(RLIMIT_CORE, 0, 0);
}

bool sandbox_this_process(const std::string& folder) {
    return prctl(PR_SET_DUMPABLE, 0) == 0 && prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
           restrict_files(folder) && filter_calls();
}

}  // namespace haarfield
