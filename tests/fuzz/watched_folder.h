#pragma once
/// Detects whether files in a folder are opened.

#include <sys/inotify.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <string>

namespace haarfield {

/// Watches a folder from its construction on.
class WatchedFolder {
public:
    explicit WatchedFolder(const std::filesystem::path& folder)
        : queue_(inotify_init1(IN_NONBLOCK | IN_CLOEXEC)) {
        if (queue_ < 0 || inotify_add_watch(queue_, folder.c_str(), IN_OPEN | IN_CREATE) < 0) abort();
    }
    ~WatchedFolder() { close(queue_); }
    WatchedFolder(const WatchedFolder&) = delete;
    WatchedFolder& operator=(const WatchedFolder&) = delete;

    /// True if a file was opened or created since the construction or the last call.
    bool has_seen_any() const {
        std::array<char, 4096> events;
        return read(queue_, events.data(), events.size()) > 0;
    }

private:
    int queue_;
};

/// Returns the names of the files and folders in a folder.
inline std::set<std::string> names_in(const std::filesystem::path& folder) {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        names.insert(entry.path().filename().string());
    return names;
}

}  // namespace haarfield
