#include "fields/file/this_process.h"

#include <signal.h>
#include <sys/prctl.h>

namespace haarfield {

std::filesystem::path running_program() {
    std::error_code failed;
    const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", failed);
    return failed ? "haarfield" : program;
}

void end_with_parent() {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
}

}  // namespace haarfield
