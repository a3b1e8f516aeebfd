#include "tools/interrupt.h"

#include "tools/command.h"
#include "tools/stopwatch.h"

#include <unistd.h>
#include <csignal>
#include <ctime>
#include <thread>

namespace haarfield {

namespace {

/// Waits for another signal while the work ends: until this process has used one second of processor time, so
/// that a busy machine does not shorten the wait, but at most ten seconds.
void wait_for_the_end(const sigset_t& signals) {
    constexpr int longest = 100;  // tenths of a second
    const Stopwatch watch;
    for (int waited = 0; waited < longest && watch.elapsed().processor < 1; ++waited) {
        const timespec tenth{0, 100'000'000};
        if (sigtimedwait(&signals, nullptr, &tenth) >= 0) return;
    }
}

}  // namespace

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
        wait_for_the_end(signals);
        _exit(static_cast<int>(ExitCode::stopped));
    }).detach();
}

}  // namespace haarfield
