#include "tools/interrupt.h"

#include "tools/command.h"

#include <unistd.h>
#include <csignal>
#include <ctime>
#include <thread>

namespace haarfield {

void stop_on_interrupt(std::stop_source source) {
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    std::thread([signals, source = std::move(source)]() mutable {
        int received = 0;
        while (sigwait(&signals, &received) != 0) {
        }
        source.request_stop();
        const timespec patience{1, 0};
        sigtimedwait(&signals, nullptr, &patience);
        _exit(static_cast<int>(ExitCode::stopped));
    }).detach();
}

}  // namespace haarfield
