#pragma once
/// A folder of fields that many scenes, processes and machines share: each is found by what it depends on.
///
/// A field's file is `NAME-SURROUNDINGS-WHOLE.vdb`: a readable name, that of the entity it was first made
/// for, and 16 hexadecimal digits each of FieldKeys. The name is for people; two entities of one name, or
/// two names of one mesh, are told by the keys alone. A file appears whole or not at all, and is never
/// changed afterwards. Its time of writing is set anew when it is used, at most once an hour.
/// `SURROUNDINGS-WHOLE` with the ending `.claim` says that a process makes the field (claim.h); without it,
/// or where it lies, two processes make the same file, and the last one stays.

#include "fields/field/field_file.h"
#include "fields/field/field_precompute.h"

#include <chrono>
#include <filesystem>

namespace haarfield {

/// The file that a field is written to.
std::filesystem::path library_file(const std::filesystem::path& folder, std::string_view entity,
                                   const FieldKeys& keys);

/// The field of an entity, as a library gives it.
struct LibraryField {
    VisibilityField field;  ///< Its entity's name may be another one with the same mesh.
    std::filesystem::path file;
    bool reused = false;
    bool surroundings_reused = false;  ///< Only local samples were made.
    std::string remade_because;        ///< Why a file that was there was not used; empty if none was there.
};

/// What makes a field that a library lacks, of what is known of it.
using FieldMaker = std::function<Result<VisibilityField>(const KnownSamples& known)>;

/// Reads the field with these keys, or makes it and adds it. While another process makes it, waits for it. If
/// the library has one with the same surroundings, these are `known`.
///
/// folder  is there.
/// errors  those of `make`; what the system says where the folder can not be written to; `interrupted`.
Result<LibraryField> library_field(const std::filesystem::path& folder, std::string_view entity,
                                   const FieldKeys& keys, Unsealed unsealed, const FieldMaker& make,
                                   const Progress& progress = {});

/// Whether the library has a field with these keys that is good, which is read for that.
bool has_library_field(const std::filesystem::path& folder, const FieldKeys& keys, Unsealed unsealed);

/// A field of a library, as listed.
struct LibraryEntry {
    std::filesystem::path file;
    std::uint64_t bytes = 0;
    std::chrono::system_clock::time_point last_used;
    FieldCard card;
    std::string trouble;  ///< Why the card can not be read; else empty.
};

/// All files of a folder that end in `.vdb`, by name; not those of other programs, which have no field in
/// them. Reads the head of each, and checks no more than that: verify_field does.
///
/// errors  there is no such folder.
Result<std::vector<LibraryEntry>> library_entries(const std::filesystem::path& folder);

/// What is to go from a library.
struct LibraryPruning {
    std::optional<std::chrono::seconds> unused_for;  ///< Fields that were not used for so long.
    std::optional<std::uint64_t> most_bytes;         ///< Then those not used for longest, down to this.
};

/// Those of the entries that are to go, those not used for longest first. Files that can not be read count,
/// and go, as others do.
std::vector<LibraryEntry> pruned_entries(std::vector<LibraryEntry> entries, const LibraryPruning& pruning,
                                         std::chrono::system_clock::time_point now);

}  // namespace haarfield
