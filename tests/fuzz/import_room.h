#pragma once
/// The folders of an import, and what it must not do in them.

#include <sys/inotify.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <string>
#include <utility>

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

/// Folders in which an import reads, writes, and must do neither.
class ImportRoom {
public:
    /// Makes empty folders inside `room`.
    explicit ImportRoom(std::filesystem::path room) : room_(std::move(room)) {
        std::filesystem::remove_all(room_);
        for (const auto& made : {models(), outside(), output()}) std::filesystem::create_directories(made);
    }

    std::filesystem::path models() const { return room_ / "models"; }    ///< For the files of the import.
    std::filesystem::path outside() const { return room_ / "outside"; }  ///< Must not be used.
    std::filesystem::path output() const { return room_ / "out"; }       ///< For what the import writes.

    /// Imports, and returns its defect and the files that were used or written in the wrong place; empty if
    /// there are none, and then removes the folders.
    ///
    /// import  () -> std::string: a defect of the import, or an empty string.
    template <class Import>
    std::string objection(const Import& import) const {
        const std::set<std::string> given = names_in(models());
        const WatchedFolder watch(outside());
        std::string wrong = import();
        if (watch.has_seen_any()) wrong += "a file outside of the import's folder was opened";
        if (names_in(room_) != std::set<std::string>{"models", "outside", "out"})
            wrong += "a file outside of the output was written";
        if (names_in(models()) != given) wrong += "a file was written next to the imported one";
        if (wrong.empty()) std::filesystem::remove_all(room_);
        return wrong;
    }

private:
    static std::set<std::string> names_in(const std::filesystem::path& folder) {
        std::set<std::string> names;
        for (const auto& entry : std::filesystem::directory_iterator(folder))
            names.insert(entry.path().filename().string());
        return names;
    }

    std::filesystem::path room_;
};

}  // namespace haarfield
