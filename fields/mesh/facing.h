#pragma once
/// Meshes whose closed pieces face as ClosedFaces says: rooms.

#include "fields/mesh/closed_pieces.h"
#include "fields/mesh/mesh_preparation.h"
#include "fields/mesh/model_file.h"

namespace haarfield {

/// As read_mesh, but for the side on which closed pieces are visible.
Result<ImportedMesh> read_mesh_facing(const ModelFile& model, std::optional<std::size_t> part,
                                      const MeshReaderOptions& options, ClosedFaces faces);

/// As prepare_mesh, but for the side on which closed pieces are visible.
Result<PreparedMesh> prepare_mesh_facing(ImportedMesh imported, const MeshPreparation& wanted,
                                         ClosedFaces faces, const Progress& progress = {});

}  // namespace haarfield
