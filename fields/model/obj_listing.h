#pragma once
/// Numbers of vertices and faces in OBJ files. assimp makes a vertex of every corner and discards the
/// numbers.

#include "fields/model/model_content.h"

#include <string_view>

namespace haarfield {

/// Finds the lines `v` and `f` that assimp reads, with bit-identical coordinates. Omits those that assimp
/// ignores (invalid coordinates, corners without a vertex).
///
/// text  as passed to assimp.
/// cost  proportional to the bytes, even for malicious files.
ContentListing obj_listing(std::string_view text);

/// Fills ContentMesh::numbers and ContentMesh::faces. A face is identified by the positions of its corners;
/// of equal faces, the first unused one is chosen.
void number_obj_vertices(const ContentListing& listing, std::vector<ContentMesh>& meshes);

}  // namespace haarfield
