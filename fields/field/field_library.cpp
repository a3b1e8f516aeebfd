#include "fields/field/field_library.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>

#include "fields/base/names.h"
#include "fields/file/claim.h"

namespace haarfield {
namespace {

using std::filesystem::path;
using Clock = std::chrono::system_clock;

constexpr std::string_view ending = ".vdb";

std::string short_hex(const ContentHash& hash) {
    return fmt::format("{:016x}", hash.high);
}

/// What the name of a field's file ends with.
std::string keys_part(const FieldKeys& keys) {
    return fmt::format("-{}-{}", short_hex(keys.surroundings), short_hex(keys.whole));
}

/// Files of a folder whose names are of that kind, by name.
template <class IsWanted>
std::vector<path> files_of(const path& folder, const IsWanted& is_wanted) {
    std::vector<path> files;
    std::error_code failed;
    for (std::filesystem::directory_iterator entry(folder, failed), end; !failed && entry != end;
         entry.increment(failed))
        if (is_wanted(entry->path().filename().string())) files.push_back(entry->path());
    std::ranges::sort(files);
    return files;
}

Clock::time_point last_used(const struct stat& status) {
    return Clock::time_point(std::chrono::duration_cast<Clock::duration>(
        std::chrono::seconds(status.st_mtim.tv_sec) + std::chrono::nanoseconds(status.st_mtim.tv_nsec)));
}

void note_use(const path& file) {
    struct stat status {};
    if (stat(file.c_str(), &status) == 0 && Clock::now() - last_used(status) > std::chrono::hours(1))
        utimensat(AT_FDCWD, file.c_str(), nullptr, 0);  // of no matter where it is not allowed
}

/// Reads the field if it is there, may be used, and has the keys.
bool find_field(const path& folder, const FieldKeys& keys, Unsealed unsealed, LibraryField& found) {
    const std::string name_end = keys_part(keys) + std::string(ending);
    for (const path& file :
         files_of(folder, [&](std::string_view name) { return name.ends_with(name_end); })) {
        Result<VisibilityField> field = read_field(file, unsealed);
        if (field && field->keys == keys) {
            note_use(file);
            found.field = *std::move(field);
            found.file = file;
            found.reused = true;
            found.remade_because.clear();
            return true;
        }
        found.remade_because = field
                                   ? fmt::format("{}: holds another field than its name says", file.string())
                                   : field.error().message();
        found.file = file;  // the new one takes its place
    }
    return false;
}

/// A field with the same surroundings.
std::optional<VisibilityField> field_with(const path& folder, const ContentHash& surroundings,
                                          Unsealed unsealed) {
    const std::string part = "-" + short_hex(surroundings) + "-";
    const std::size_t from_end = part.size() + short_hex({}).size() + ending.size();
    for (const path& file : files_of(folder, [&](std::string_view name) {
             return name.ends_with(ending) && name.size() > from_end &&
                    name.substr(name.size() - from_end).starts_with(part);
         }))
        if (Result<VisibilityField> field = read_field(file, unsealed);
            field && field->keys.surroundings == surroundings)
            return *std::move(field);
    return std::nullopt;
}

}  // namespace

path library_file(const path& folder, std::string_view entity, const FieldKeys& keys) {
    constexpr std::size_t longest_name = 80;  // bytes
    return folder / (plain_name(entity.substr(0, longest_name)) + keys_part(keys) + std::string(ending));
}

Result<LibraryField> library_field(const path& folder, std::string_view entity, const FieldKeys& keys,
                                   Unsealed unsealed, const FieldMaker& make, const Progress& progress) {
    LibraryField result;
    if (find_field(folder, keys, unsealed, result)) return result;
    // Held while the field is made: who wants the same one waits for it, and a folder where nothing can be
    // written is noticed before the work.
    const Result<std::optional<Claim>> claim =
        Claim::on(folder / (keys_part(keys).substr(1) + claim_ending), progress);
    if (!claim) return claim.error();
    if (find_field(folder, keys, unsealed, result)) return result;  // another process made it meanwhile
    KnownSamples known;
    std::optional<SampleRun> surroundings;
    if (const std::optional<VisibilityField> other = field_with(folder, keys.surroundings, unsealed)) {
        surroundings = surrounding_samples(*other);
        known = {{&*surroundings, 1}, other->error};
        result.surroundings_reused = true;
    }
    Result<VisibilityField> field = make(known);
    if (!field) return field.error();
    if (result.file.empty()) result.file = library_file(folder, entity, keys);
    if (const Result<Done> written = write_field(*field, result.file); !written) return written.error();
    result.field = *std::move(field);
    return result;
}

bool has_library_field(const path& folder, const FieldKeys& keys, Unsealed unsealed) {
    LibraryField found;
    return find_field(folder, keys, unsealed, found);
}

Result<std::vector<LibraryEntry>> library_entries(const path& folder) {
    std::error_code unknown;
    if (!std::filesystem::is_directory(folder, unknown))
        return Error{folder.string(), "is no folder; wanted one of fields"};
    std::vector<LibraryEntry> entries;
    for (const path& file : files_of(folder, [](std::string_view name) { return name.ends_with(ending); })) {
        struct stat status {};
        if (stat(file.c_str(), &status) != 0) continue;  // removed meanwhile
        LibraryEntry entry{file, static_cast<std::uint64_t>(status.st_size), last_used(status), {}, {}};
        Result<FieldCard> card = read_field_card(file);
        if (card)
            entry.card = *std::move(card);
        else
            entry.trouble = card.error().what;
        entries.push_back(std::move(entry));
    }
    return entries;
}

std::vector<LibraryEntry> pruned_entries(std::vector<LibraryEntry> entries, const LibraryPruning& pruning,
                                         Clock::time_point now) {
    std::ranges::stable_sort(entries, {}, &LibraryEntry::last_used);
    std::uint64_t bytes = 0;
    for (const LibraryEntry& entry : entries) bytes += entry.bytes;
    const auto is_to_go = [&](const LibraryEntry& entry) {
        return (pruning.unused_for && now - entry.last_used > *pruning.unused_for) ||
               (pruning.most_bytes && bytes > *pruning.most_bytes);
    };
    std::size_t count = 0;
    while (count < entries.size() && is_to_go(entries[count])) bytes -= entries[count++].bytes;
    entries.resize(count);
    return entries;
}

}  // namespace haarfield
