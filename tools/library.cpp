#include "fields/field/field_library.h"
#include "fields/file/claim.h"
#include "fields/file/temporary_file.h"
#include "tools/command.h"
#include "tools/library_sizes.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <CLI/CLI.hpp>

namespace haarfield {

namespace {

using Clock = std::chrono::system_clock;

struct LibraryOptions {
    std::string folder;
    bool json = false, verify = false, dry_run = false;
    std::string unused_for, most_bytes;  // duration_of and byte_count_of parse them; empty: no limit
};

std::string time_text(Clock::time_point time) {
    return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(Clock::to_time_t(time)));
}

nlohmann::ordered_json entry_json(const LibraryEntry& entry) {
    nlohmann::ordered_json json{{"file", entry.file.filename().string()},
                                {"kind", is_mesh(entry) ? "mesh" : "field"},
                                {"bytes", entry.bytes},
                                {"last_used", time_text(entry.last_used)}};
    if (!entry.trouble.empty()) {
        json["trouble"] = entry.trouble;
        return json;
    }
    json["entity"] = entry.entity;
    if (!entry.card) return json;
    const FieldCard& card = *entry.card;
    json["key"] = card.keys.whole.hex();
    json["surroundings"] = card.keys.surroundings.hex();
    json["planar_samples"] = card.planar_samples;
    json["spherical_samples"] = card.spherical_samples;
    json["local_samples"] = card.local_samples;
    json["planar_error"] = card.error.planar.relative;
    json["spherical_error"] = card.error.spherical.relative;
    return json;
}

void print_entry(const LibraryEntry& entry, const CommandContext& context) {
    const std::string name = entry.file.filename().string();
    const double megabytes = double(entry.bytes) / 1e6;
    const std::string used = fmt::format("{:%Y-%m-%d %H:%M}", fmt::gmtime(Clock::to_time_t(entry.last_used)));
    if (!entry.trouble.empty()) {
        context.print("{:<24} {:>8.2f} MB  {}  {}: {}\n", "?", megabytes, used, name, entry.trouble);
        return;
    }
    if (!entry.card) {
        context.print("{:<24} {:>8.2f} MB  {}  prepared mesh  {}\n", entry.entity, megabytes, used, name);
        return;
    }
    const FieldCard& card = *entry.card;
    context.print(
        "{:<24} {:>8.2f} MB  {}  {:>8} samples  error {:>4.1f} % on the ground, {:>4.1f} % around  {}\n",
        entry.entity, megabytes, used, card.planar_samples + card.spherical_samples + card.local_samples,
        100 * card.error.planar.relative, 100 * card.error.spherical.relative, name);
}

/// Adds `good` or `trouble` to each entry's JSON. Returns the number of bad entries.
Result<std::size_t> verify_all(const std::vector<LibraryEntry>& entries, nlohmann::ordered_json& fields,
                               CommandContext& context) {
    std::size_t bad = 0;
    for (std::size_t i = 0; i < entries.size(); ++i) {
        if (context.progress.stop.stop_requested()) return interruption();
        const Result<Done> verdict = verify_entry(entries[i]);
        fields[i]["good"] = bool(verdict);
        if (!verdict) {
            fields[i]["trouble"] = verdict.error().what;
            context.message(verdict.error().message());
            ++bad;
        }
        if (context.progress.report) context.progress.report("verifying", i + 1, entries.size());
    }
    return bad;
}

/// Removes the entries that the options select. Returns the names of their files.
Result<nlohmann::ordered_json> prune(const LibraryOptions& options, const std::vector<LibraryEntry>& entries,
                                     const CommandContext& context) {
    LibraryPruning pruning;
    if (!options.unused_for.empty()) pruning.unused_for = duration_of(options.unused_for);
    if (!options.most_bytes.empty()) pruning.most_bytes = byte_count_of(options.most_bytes);
    nlohmann::ordered_json removed = nlohmann::ordered_json::array();
    for (const LibraryEntry& entry : pruned_entries(entries, pruning, Clock::now())) {
        std::error_code failed;
        if (!options.dry_run) std::filesystem::remove(entry.file, failed);
        if (failed) return Error{entry.file.string(), "cannot be removed: " + failed.message()};
        removed.push_back(entry.file.filename().string());
        if (!options.json)
            context.print("{} {}\n", options.dry_run ? "would remove" : "removed",
                          entry.file.filename().string());
    }
    return removed;
}

Result<ExitCode> run(const LibraryOptions& options, CommandContext& context) {
    HF_TRY(const std::vector<LibraryEntry> entries, library_entries(options.folder));
    const bool prunes = !options.unused_for.empty() || !options.most_bytes.empty();
    nlohmann::ordered_json fields = nlohmann::ordered_json::array();
    std::uint64_t bytes = 0;
    for (const LibraryEntry& entry : entries) {
        fields.push_back(entry_json(entry));
        bytes += entry.bytes;
        if (!options.json && !prunes) print_entry(entry, context);
    }
    const auto meshes = std::size_t(std::ranges::count_if(entries, is_mesh));
    std::size_t bad = 0;
    if (options.verify) {
        HF_TRY(const std::size_t verified, verify_all(entries, fields, context));
        bad = verified;
    }
    nlohmann::ordered_json listing{{"folder", options.folder}, {"bytes", bytes}, {"fields", fields}};
    if (prunes) {
        if (!options.dry_run) {
            remove_abandoned_files(options.folder);
            remove_abandoned_claims(options.folder);
        }
        HF_TRY(nlohmann::ordered_json removed, prune(options, entries, context));
        listing["removed"] = std::move(removed);
    }
    context.report["library"] = listing;
    if (options.json)
        print(stdout, "{}\n", listing.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
    else if (!prunes)
        context.print("{} fields, {} prepared meshes, {:.2f} MB{}\n", entries.size() - meshes, meshes,
                      double(bytes) / 1e6,
                      !options.verify ? ""
                      : bad == 0      ? ", all good"
                                      : fmt::format(", {} damaged", bad));
    return bad == 0 ? ExitCode::done : ExitCode::failed;
}

std::string duration_trouble(const std::string& text) {
    return duration_of(text) ? ""
                             : fmt::format("is {}; expected a number with s, min, h or d, such as 30d", text);
}

std::string size_trouble(const std::string& text) {
    return byte_count_of(text) ? "" : fmt::format("is {}; expected a number with kB, MB, GB or TB", text);
}

}  // namespace

Command library_command(CLI::App& program) {
    CLI::App* app = program.add_subcommand(
        "library", "List, verify or prune a folder of visibility fields and prepared meshes");
    const auto options = std::make_shared<LibraryOptions>();
    app->add_option("DIR", options->folder, "The folder, as given to --fields")->required()->type_name("");
    app->add_flag("--json", options->json, "Print JSON");
    app->add_flag("--verify", options->verify,
                  "Verify each file; exit code 1 if one is damaged. Scenes that need it recompute it");
    app->add_option("--unused-for", options->unused_for,
                    "Remove files that no command has used for this time, such as 36h or 30d")
        ->check(CLI::Validator(duration_trouble, ""))
        ->type_name("TIME");
    app->add_option("--shrink-to", options->most_bytes,
                    "Remove the least recently used files until the total size is at most SIZE, such as 20GB")
        ->check(CLI::Validator(size_trouble, ""))
        ->type_name("SIZE");
    app->add_flag("--dry-run", options->dry_run,
                  "Print the files that would be removed, without removing them");
    app->footer(
        "Any number of scenes, processes and machines may share a library while it is pruned. Missing\n"
        "files are computed again.\n"
        "Example:\n"
        "  haarfield library out/fields --verify\n"
        "  haarfield library out/fields --unused-for 30d");
    return {app, [options](CommandContext& context) { return run(*options, context); }};
}

}  // namespace haarfield
