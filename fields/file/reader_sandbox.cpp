#include "fields/file/reader_sandbox.h"

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <vector>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define HAARFIELD_SHADOW_MEMORY
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define HAARFIELD_SHADOW_MEMORY
#endif
#endif

namespace haarfield {
namespace {

void limit(__rlimit_resource resource, rlim_t soft, rlim_t hard) {
    rlimit now{};
    if (getrlimit(resource, &now) != 0) return;
    now.rlim_cur = std::min(soft, now.rlim_max);
    now.rlim_max = std::min(hard, now.rlim_max);
    setrlimit(resource, &now);
}

#if defined(__x86_64__)
constexpr std::uint32_t architecture = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr std::uint32_t architecture = AUDIT_ARCH_AARCH64;
#else
constexpr std::uint32_t architecture = 0;
#endif

/// What changes files or names of them, reaches other processes or a network, or starts a program. Calls
/// that threads and memory need are not among them.
constexpr std::uint32_t forbidden[] = {
    SYS_socket,
    SYS_connect,
    SYS_bind,
    SYS_listen,
    SYS_accept,
    SYS_accept4,
    SYS_sendto,
    SYS_sendmsg,
    SYS_sendmmsg,
    SYS_execve,
    SYS_execveat,
    SYS_ptrace,
    SYS_kill,
    SYS_pidfd_open,
    SYS_pidfd_getfd,
    SYS_pidfd_send_signal,
    SYS_process_vm_readv,
    SYS_unlinkat,
    SYS_renameat,
    SYS_renameat2,
    SYS_mkdirat,
    SYS_linkat,
    SYS_symlinkat,
    SYS_mknodat,
    SYS_fchmodat,
    SYS_fchownat,
    SYS_truncate,
    SYS_process_vm_writev,
    SYS_mount,
    SYS_umount2,
    SYS_pivot_root,
    SYS_chroot,
    SYS_setns,
    SYS_unshare,
    SYS_bpf,
    SYS_io_uring_setup,
    SYS_userfaultfd,
    SYS_keyctl,
    SYS_add_key,
    SYS_perf_event_open,
    SYS_setxattr,
    SYS_utimensat,
    SYS_init_module,
    SYS_finit_module,
#if defined(__x86_64__)
    SYS_creat,
    SYS_unlink,
    SYS_rename,
    SYS_mkdir,
    SYS_rmdir,
    SYS_link,
    SYS_symlink,
    SYS_mknod,
    SYS_chmod,
    SYS_chown,
    SYS_fork,
    SYS_vfork,
#endif
};

/// A filter of system calls, put together line by line.
class CallFilter {
public:
    CallFilter() {
        take(offsetof(seccomp_data, arch));
        program_.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, architecture, 1, 0));
        answer(SECCOMP_RET_ERRNO | EPERM);
        take(offsetof(seccomp_data, nr));
        for (const std::uint32_t call : forbidden) answer_call(call, EPERM);
        // Their flags lie in memory, where a filter does not see them: libraries then take the older calls.
        answer_call(SYS_clone3, ENOSYS);
        answer_call(SYS_openat2, ENOSYS);
        constexpr std::uint32_t writing = O_WRONLY | O_RDWR | O_CREAT | O_TRUNC;
        answer_call_with(SYS_openat, 2, writing, /*with_any=*/true, EACCES);
#if defined(__x86_64__)
        answer_call_with(SYS_open, 1, writing, /*with_any=*/true, EACCES);
#endif
        answer_call_with(SYS_clone, 0, CLONE_VM, /*with_any=*/false, EPERM);  // threads share memory
        answer(SECCOMP_RET_ALLOW);
    }

    bool install() {
        const sock_fprog program{static_cast<unsigned short>(program_.size()), program_.data()};
        return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
               prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program, 0, 0) == 0;
    }

private:
    void take(std::size_t offset) {
        program_.push_back(BPF_STMT(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(offset)));
    }
    void answer(std::uint32_t what) {
        program_.push_back(BPF_STMT(BPF_RET | BPF_K, what));
    }

    void answer_call(std::uint32_t call, int error) {
        program_.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, call, 0, 1));
        answer(SECCOMP_RET_ERRNO | static_cast<std::uint32_t>(error));
    }
    /// Answers a call by the lower half of one of its arguments: if it has any of the bits, or none of them.
    void answer_call_with(std::uint32_t call, std::size_t argument, std::uint32_t bits, bool with_any,
                          int error) {
        program_.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, call, 0, 4));
        take(offsetof(seccomp_data, args) + argument * sizeof(std::uint64_t));
        const std::uint8_t over_answer = 1;
        if (with_any)
            program_.push_back(BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, bits, 0, over_answer));
        else
            program_.push_back(BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, bits, over_answer, 0));
        answer(SECCOMP_RET_ERRNO | static_cast<std::uint32_t>(error));
        take(offsetof(seccomp_data, nr));
    }

    std::vector<sock_filter> program_;
};

}  // namespace

void limit_this_process(const ReaderLimits& limits) {
#ifndef HAARFIELD_SHADOW_MEMORY
    std::uint64_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    const rlim_t memory = pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) + limits.memory;
    limit(RLIMIT_AS, memory, memory);
#endif
    const auto seconds = static_cast<rlim_t>(std::ceil(std::clamp(limits.seconds, 1.0, 1e6)));
    limit(RLIMIT_CPU, seconds, seconds + 1);
    limit(RLIMIT_FSIZE, limits.memory, limits.memory);
    limit(RLIMIT_NOFILE, 64, 64);
    limit(RLIMIT_CORE, 0, 0);
}

bool sandbox_this_process() {
    return architecture != 0 && CallFilter().install();
}

}  // namespace haarfield
