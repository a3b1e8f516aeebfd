#pragma once
/// The vertices and faces of OBJ files by their numbers: assimp makes a vertex of every corner, and forgets
/// them.

#include "fields/model/model_content.h"

#include <string_view>

namespace haarfield {

/// Finds the lines `v` and `f` that assimp reads, with coordinates of the same bits; what assimp does not
/// take (coordinates that are no numbers, corners without a vertex) is left out.
///
/// text  as assimp is given it.
/// cost  proportional to the bytes, whatever they say.
ContentListing obj_listing(std::string_view text);

/// Fills ContentMesh::numbers and ContentMesh::faces: a face is known by the places of its corners, and of
/// equal ones the first that is left is taken.
void number_obj_vertices(const ContentListing& listing, std::vector<ContentMesh>& meshes);

}  // namespace haarfield
