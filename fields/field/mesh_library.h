#pragma once
/// Prepared meshes in a library of fields. Everything that depends on a mesh and its preparation alone is
/// computed by the first command that needs it. Later commands read it.
///
/// A prepared mesh is a section file `NAME-KEY.haarmesh`, where KEY is 16 hexadecimal digits of
/// preparation_key. Like a field, it appears complete or not at all, and its modification time is updated on
/// use. A damaged file is treated as missing. Its bytes are in native order, so that machines of another byte
/// order treat it as missing, too.

#include "fields/field/entity_occlusion.h"
#include "fields/field/visibility_field.h"

#include <filesystem>
#include <optional>
#include <string>

namespace haarfield {

/// Returns the hash of everything that prepare_mesh and EntityOcclusion depend on.
ContentHash preparation_key(const ImportedMesh& imported, const MeshPreparation& wanted);

/// A prepared mesh from a library.
struct LibraryMesh {
    PreparedMesh mesh;
    KnownOcclusion occlusion;
};

/// Finds a prepared mesh. Nothing if the library has none that is valid.
///
/// cost  about 2 ns per byte.
std::optional<LibraryMesh> find_library_mesh(const std::filesystem::path& folder, const ContentHash& key);

/// Adds a prepared mesh to a library. Makes occlusion.coarser.
///
/// errors  those of write_file; `interrupted`.
Result<Done> add_library_mesh(const std::filesystem::path& folder, std::string_view entity,
                              const ContentHash& key, const PreparedMesh& mesh,
                              const EntityOcclusion& occlusion, const Progress& progress = {});

/// Reads and verifies all of a prepared mesh: checksum, sizes of arrays and indices.
Result<LibraryMesh> read_library_mesh(const std::filesystem::path& file);

/// Reads the entity for which a mesh was prepared. Verifies no checksum.
///
/// cost  a few pages of the file.
Result<std::string> read_library_mesh_entity(const std::filesystem::path& file);

}  // namespace haarfield
