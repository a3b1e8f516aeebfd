#pragma once
/// Limits on the node hierarchy of a glTF file, which determines the cost of reading it.

#include "fields/base/result.h"

#include <string_view>

namespace haarfield {

/// Properties of a glTF file that check_gltf_nodes has accepted.
struct GltfDepth {
    std::size_t nodes = 0;  ///< On the longest path from a root to a leaf.
};

/// Scans the JSON of a glTF file before a recursive parser reads it. Text that is not JSON is left to that
/// parser.
///
/// errors  (with an empty `where`) values nested deeper than 1000; paths of more than 100,000 nodes; a node
///         that is its own descendant; more than a million instances through nodes with several parents.
/// cost    linear in the text.
Result<GltfDepth> check_gltf_nodes(std::string_view json);

}  // namespace haarfield
