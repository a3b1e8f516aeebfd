#pragma once
/// A folder of fields that many scenes, processes and machines share. A field is identified by everything
/// that it depends on.
///
/// A field's file is `NAME-SURROUNDINGS-WHOLE.vdb`: the name of the entity that it was first computed for,
/// and 16 hexadecimal digits each of FieldKeys. The name is only for people; the keys alone distinguish
/// fields. Prepared meshes are stored beside them (mesh_library.h). A file appears complete or not at all,
/// and its content never changes afterwards. Its modification time is updated on use, at most once an hour.
/// `SURROUNDINGS-WHOLE.claim` states that a process is computing the field (claim.h). If a claim is missing
/// or wrong, two processes compute the same file, and the last one is kept.

#include "fields/field/field_file.h"
#include "fields/field/field_precompute.h"

#include <chrono>
#include <filesystem>

namespace haarfield {

/// Returns the file that a field is written to.
std::filesystem::path library_file(const std::filesystem::path& folder, std::string_view entity,
                                   const FieldKeys& keys);

/// An entity's field from a library.
struct LibraryField {
    VisibilityField field;  ///< The name of its entity may differ: another one with the same mesh.
    std::filesystem::path file;
    bool reused = false;
    bool surroundings_reused = false;  ///< Only local samples were computed.
    std::string recomputed_because;    ///< Why an existing file was not used; empty if there was none.
};

/// Computes a field that a library lacks, given its known samples.
using FieldMaker = std::function<Result<VisibilityField>(const PrecomputedSamples& known)>;

/// Reads the field with these keys, or computes and adds it. Waits while another process computes it. If the
/// library has a field with the same surroundings, `known` contains these.
///
/// folder  must exist.
/// errors  those of `make`; those of the system if the folder is not writable; `interrupted`.
Result<LibraryField> library_field(const std::filesystem::path& folder, std::string_view entity,
                                   const FieldKeys& keys, const FieldMaker& make,
                                   const Progress& progress = {});

/// Tests whether the library has a valid field with these keys. Reads the whole field.
bool has_library_field(const std::filesystem::path& folder, const FieldKeys& keys);

/// A field or a prepared mesh (mesh_library.h) of a library, as listed.
struct LibraryEntry {
    std::filesystem::path file;
    std::uint64_t bytes = 0;
    std::chrono::system_clock::time_point last_used;
    std::string entity{};             ///< The entity that it was made for.
    std::optional<FieldCard> card{};  ///< Of a field.
    std::string trouble{};            ///< Why entity and card cannot be read; otherwise empty.
};

/// True for a prepared mesh, or a file that has the name of one.
bool is_mesh(const LibraryEntry& entry);

/// Lists all fields of a folder, then all prepared meshes, each by name. Reads and verifies only the head of
/// each file.
///
/// errors  there is no such folder.
Result<std::vector<LibraryEntry>> library_entries(const std::filesystem::path& folder);

/// Reads and verifies all of an entry: verify_field or read_library_mesh.
Result<Done> verify_entry(const LibraryEntry& entry);

/// The rule that selects fields to remove from a library.
struct LibraryPruning {
    /// Remove fields that were not used for longer than this.
    std::optional<std::chrono::seconds> unused_for;
    std::optional<std::uint64_t> most_bytes;  ///< Then remove the least recently used, down to this size.
};

/// Returns the entries to remove, least recently used first. Unreadable files count like any others.
std::vector<LibraryEntry> pruned_entries(std::vector<LibraryEntry> entries, const LibraryPruning& pruning,
                                         std::chrono::system_clock::time_point now);

}  // namespace haarfield
