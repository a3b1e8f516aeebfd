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

/// Returns the end of a field's file name.
std::string keys_part(const FieldKeys& keys) {
    return fmt::format("-{}-{}", short_hex(keys.surroundings), short_hex(keys.whole));
}

/// Returns the files of a folder whose names satisfy the predicate, sorted by name.
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
        utimensat(AT_FDCWD, file.c_str(), nullptr, 0);  // fails harmlessly without permission
}

/// Reads the field with these keys, if it exists and is valid.
bool find_field(const path& folder, const FieldKeys& keys, LibraryField& found) {
    const std::string name_end = keys_part(keys) + std::string(ending);
    for (const path& file :
         files_of(folder, [&](std::string_view name) { return name.ends_with(name_end); })) {
        Result<VisibilityField> field = read_field(file);
        if (field && field->keys == keys) {
            note_use(file);
            found.field = *std::move(field);
            found.file = file;
            found.reused = true;
            found.recomputed_because.clear();
            return true;
        }
        found.recomputed_because =
            field ? fmt::format("{}: contains a different field than its name indicates", file.string())
                  : field.error().message();
        found.file = file;  // the new field replaces it
    }
    return false;
}

/// Returns a field with the same surroundings, if there is one.
std::optional<VisibilityField> field_with(const path& folder, const ContentHash& surroundings) {
    const std::string part = "-" + short_hex(surroundings) + "-";
    const std::size_t from_end = part.size() + short_hex({}).size() + ending.size();
    for (const path& file : files_of(folder, [&](std::string_view name) {
             return name.ends_with(ending) && name.size() > from_end &&
                    name.substr(name.size() - from_end).starts_with(part);
         }))
        if (Result<VisibilityField> field = read_field(file);
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
                                   const FieldMaker& make, const Progress& progress) {
    LibraryField result;
    if (find_field(folder, keys, result)) return result;
    // Held while the field is computed. Other processes that need it wait, and a folder that is not writable
    // is detected before the work.
    HF_TRY(const std::optional<Claim> claim,
           Claim::on(folder / (keys_part(keys).substr(1) + claim_ending), progress));
    if (find_field(folder, keys, result)) return result;  // another process made it meanwhile
    PrecomputedSamples known;
    std::optional<SampleRun> surroundings;
    if (const std::optional<VisibilityField> other = field_with(folder, keys.surroundings)) {
        surroundings = surrounding_samples(*other);
        known = {{&*surroundings, 1}, other->error};
        result.surroundings_reused = true;
    }
    HF_TRY(VisibilityField field, make(known));
    if (result.file.empty()) result.file = library_file(folder, entity, keys);
    HF_TRY_DONE(write_field(field, result.file));
    result.field = std::move(field);
    return result;
}

bool has_library_field(const path& folder, const FieldKeys& keys) {
    LibraryField found;
    return find_field(folder, keys, found);
}

Result<std::vector<LibraryEntry>> library_entries(const path& folder) {
    std::error_code unknown;
    if (!std::filesystem::is_directory(folder, unknown))
        return Error{folder.string(), "is not a directory; expected a directory of fields"};
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
