#pragma once
/// The node hierarchy of a glTF file, as far as it decides what reading the file costs.

#include "fields/base/result.h"

#include <string_view>

namespace haarfield {

/// Measures of a glTF file that has passed check_gltf_nodes.
struct GltfDepth {
    std::size_t nodes = 0;  ///< Of the longest path from a root to a leaf.
};

/// Scans the JSON of a glTF file before a recursive parser reads it. Anything that is not JSON is left to
/// that parser.
///
/// errors  (with an empty `where`) values nested deeper than 1000; paths of more than 100,000 nodes; a node
///         that is its own descendant; nodes with several parents that make more than a million instances.
/// cost    linear in the text.
Result<GltfDepth> check_gltf_nodes(std::string_view json);

}  // namespace haarfield
