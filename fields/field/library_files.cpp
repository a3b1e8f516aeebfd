#include "fields/field/library_files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>

#include "fields/base/names.h"

namespace haarfield {

using std::filesystem::path;
using Clock = std::chrono::system_clock;

std::string short_hex(const ContentHash& hash) {
    return fmt::format("{:016x}", hash.high);
}

path library_path(const path& folder, std::string_view entity, std::string_view name_end) {
    constexpr std::size_t longest_name = 80;  // bytes
    return folder / (plain_name(entity.substr(0, longest_name)) + std::string(name_end));
}

std::vector<path> files_ending(const path& folder, std::string_view name_end) {
    std::vector<path> files;
    std::error_code failed;
    for (std::filesystem::directory_iterator entry(folder, failed), end; !failed && entry != end;
         entry.increment(failed))
        if (entry->path().filename().string().ends_with(name_end)) files.push_back(entry->path());
    std::ranges::sort(files);
    return files;
}

std::optional<FileUse> file_use(const path& file) {
    struct stat status {};
    if (stat(file.c_str(), &status) != 0) return std::nullopt;
    return FileUse{
        static_cast<std::uint64_t>(status.st_size),
        Clock::time_point(std::chrono::duration_cast<Clock::duration>(
            std::chrono::seconds(status.st_mtim.tv_sec) + std::chrono::nanoseconds(status.st_mtim.tv_nsec)))};
}

void note_use(const path& file) {
    const std::optional<FileUse> use = file_use(file);
    if (use && Clock::now() - use->last_used > std::chrono::hours(1))
        utimensat(AT_FDCWD, file.c_str(), nullptr, 0);
}

}  // namespace haarfield
