#include "fields/field/field_library.h"

#include <fmt/format.h>

#include <algorithm>

#include "fields/field/library_files.h"
#include "fields/field/mesh_library.h"
#include "fields/file/claim.h"

namespace haarfield {
namespace {

using std::filesystem::path;
using Clock = std::chrono::system_clock;

/// Returns the end of a field's file name.
std::string keys_part(const FieldKeys& keys) {
    return fmt::format("-{}-{}", short_hex(keys.surroundings), short_hex(keys.whole));
}

/// Reads the field with these keys, if it exists and is valid.
bool find_field(const path& folder, const FieldKeys& keys, LibraryField& found) {
    for (const path& file : files_ending(folder, keys_part(keys) + std::string(field_ending))) {
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
    const std::string part = fmt::format("-{}-", short_hex(surroundings));
    const std::size_t from_end = part.size() + short_hex({}).size() + field_ending.size();
    const auto has_part = [&](const std::string& name) {
        return name.size() > from_end && name.compare(name.size() - from_end, part.size(), part) == 0;
    };
    for (const path& file : files_ending(folder, field_ending))
        if (has_part(file.filename().string()))
            if (Result<VisibilityField> field = read_field(file);
                field && field->keys.surroundings == surroundings)
                return *std::move(field);
    return std::nullopt;
}

LibraryEntry field_entry(const path& file, const FileUse& use) {
    LibraryEntry entry{file, use.bytes, use.last_used};
    Result<FieldCard> card = read_field_card(file);
    if (card) {
        entry.entity = card->entity;
        entry.card = *std::move(card);
    } else {
        entry.trouble = card.error().what;
    }
    return entry;
}

LibraryEntry mesh_entry(const path& file, const FileUse& use) {
    LibraryEntry entry{file, use.bytes, use.last_used};
    const Result<std::string> entity = read_library_mesh_entity(file);
    if (entity)
        entry.entity = *entity;
    else
        entry.trouble = entity.error().what;
    return entry;
}

}  // namespace

path library_file(const path& folder, std::string_view entity, const FieldKeys& keys) {
    return library_path(folder, entity, keys_part(keys) + std::string(field_ending));
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
    for (const std::string_view ending : {field_ending, mesh_ending})
        for (const path& file : files_ending(folder, ending))
            if (const std::optional<FileUse> use = file_use(file))  // otherwise removed meanwhile
                entries.push_back(ending == field_ending ? field_entry(file, *use) : mesh_entry(file, *use));
    return entries;
}

bool is_mesh(const LibraryEntry& entry) {
    return entry.file.extension() == mesh_ending;
}

Result<Done> verify_entry(const LibraryEntry& entry) {
    if (!is_mesh(entry)) return verify_field(entry.file);
    HF_TRY_DONE(read_library_mesh(entry.file));
    return Done{};
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
