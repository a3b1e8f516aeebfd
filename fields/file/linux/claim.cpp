#include "fields/file/claim.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <utility>

#include "fields/file/process_name.h"

namespace haarfield {
namespace {

using std::filesystem::path;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds renewal(5);

Error system_error(const path& file, const char* action, int number) {
    return {file.string(), fmt::format("cannot {}: {}", action, std::strerror(number))};
}

bool is_same_file(const struct stat& a, const struct stat& b) {
    return a.st_dev == b.st_dev && a.st_ino == b.st_ino;
}

/// The state of a claim file at one time.
struct ClaimState {
    struct stat status {};
    std::string process;
};

/// Reads a claim; nothing if there is none.
std::optional<ClaimState> claim_state(const path& file) {
    const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
    if (descriptor < 0) return std::nullopt;
    ClaimState state;
    char text[256];
    const ssize_t size = read(descriptor, text, sizeof text);
    if (size > 0) state.process.assign(text, static_cast<std::size_t>(size));
    const bool known = fstat(descriptor, &state.status) == 0;
    close(descriptor);
    return known ? std::optional(state) : std::nullopt;
}

bool is_renewed(const ClaimState& before, const ClaimState& now) {
    return !is_same_file(before.status, now.status) ||
           before.status.st_mtim.tv_sec != now.status.st_mtim.tv_sec ||
           before.status.st_mtim.tv_nsec != now.status.st_mtim.tv_nsec;
}

/// Returns a name next to the claim that no other process uses. remove_abandoned_files recognises it.
path own_name(const path& file) {
    path own = file;
    own += fmt::format(".{}.{}.tmp", process_name(), Clock::now().time_since_epoch().count());
    return own;
}

/// Removes a claim that is no longer renewed, but not one that has replaced it in the meantime.
void remove_stale(const path& file, const ClaimState& stale) {
    const path moved = own_name(file);
    if (std::rename(file.c_str(), moved.c_str()) != 0) return;
    const std::optional<ClaimState> moved_state = claim_state(moved);
    if (moved_state && !is_same_file(moved_state->status, stale.status))
        (void)!link(moved.c_str(), file.c_str());  // another process holds it: restore it
    unlink(moved.c_str());
}

enum class Attempt { made, moved_state, impossible };

/// Creates a claim. It appears with its content in one step or not at all, also on network file systems.
Result<Attempt> make_claim(const path& file) {
    const path own = own_name(file);
    const int descriptor = open(own.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (descriptor < 0) return system_error(file, "create a file next to it", errno);
    const std::string name = process_name();
    const bool written = write(descriptor, name.data(), name.size()) == static_cast<ssize_t>(name.size());
    close(descriptor);
    const int failure = written && link(own.c_str(), file.c_str()) == 0 ? 0 : written ? errno : ENOSPC;
    unlink(own.c_str());
    if (failure == 0) return Attempt::made;
    if (failure == EEXIST) return Attempt::moved_state;
    if (failure == EPERM || failure == ENOTSUP || failure == ENOSYS || failure == EMLINK)
        return Attempt::impossible;
    return system_error(file, "create it", failure);
}

}  // namespace

Result<std::optional<Claim>> Claim::on(const path& file, const Progress& progress,
                                       std::chrono::milliseconds patience) {
    std::optional<ClaimState> last;
    Clock::time_point last_renewal = Clock::now();
    while (true) {
        HF_TRY(const Attempt attempt, make_claim(file));
        if (attempt == Attempt::impossible) return std::optional<Claim>();
        if (attempt == Attempt::made) {
            const int descriptor = open(file.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW);
            if (descriptor < 0) return system_error(file, "open it", errno);
            return std::optional(Claim(file, descriptor));
        }
        const std::optional<ClaimState> state = claim_state(file);
        if (!state) continue;  // released in the meantime
        if (!last || is_renewed(*last, *state)) last_renewal = Clock::now();
        last = state;
        if (process_liveness(state->process) == Liveness::ended || Clock::now() - last_renewal > patience) {
            remove_stale(file, *state);
            continue;
        }
        if (progress.stop.stop_requested()) return interruption(file.string());
        if (progress.report)
            progress.report("waiting for another process that computes " + file.stem().string(), 0, 1);
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
}

Claim::Claim(path file, int descriptor) : file_(std::move(file)), descriptor_(descriptor) {
    renewing_ = std::jthread([descriptor](const std::stop_token& stop) {
        std::mutex mutex;
        std::condition_variable_any stopped;
        std::unique_lock lock(mutex);
        while (!stopped.wait_for(lock, stop, renewal, [&stop] { return stop.stop_requested(); }))
            futimens(descriptor, nullptr);
    });
}

Claim::Claim(Claim&& other) noexcept
    : file_(std::move(other.file_)),
      descriptor_(std::exchange(other.descriptor_, -1)),
      renewing_(std::move(other.renewing_)) {}

Claim::~Claim() {
    if (descriptor_ < 0) return;
    renewing_ = {};
    struct stat held {
    }, named{};
    if (fstat(descriptor_, &held) == 0 && stat(file_.c_str(), &named) == 0 && is_same_file(held, named))
        unlink(file_.c_str());
    close(descriptor_);
}

void remove_abandoned_claims(const path& folder) {
    std::error_code failed;
    for (std::filesystem::directory_iterator entry(folder, failed), end; !failed && entry != end;
         entry.increment(failed)) {
        if (entry->path().extension() != claim_ending) continue;
        const std::optional<ClaimState> state = claim_state(entry->path());
        if (state && process_liveness(state->process) == Liveness::ended) remove_stale(entry->path(), *state);
    }
}

}  // namespace haarfield
