#include "shading/visibility/texel_tree.h"

#include <algorithm>
#include <cstring>

namespace haarfield {
namespace {

bool is_uniform(std::span<const std::uint8_t> open) {
    return std::memcmp(open.data(), open.data() + 1, open.size() - 1) == 0;
}

}  // namespace

TexelTreeMaker::TexelTreeMaker(int face_size)
    : face_size_(face_size), upper_(static_cast<std::size_t>(std::max(wide_levels(face_size), 1)) - 1) {
    for (std::size_t level = 0; level < upper_.size(); ++level) {
        upper_[level].open.resize(std::size_t(1) << (4 * level));
        upper_[level].varies.resize(std::size_t(1) << (4 * level));
    }
}

void TexelTreeMaker::make(std::span<const std::uint8_t> all, TexelTree& tree) {
    const std::size_t texels = all.size() / cubemap_faces;
    tree.nodes.clear();
    std::array<std::size_t, cubemap_faces + 1> root{};
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        const std::span<const std::uint8_t> open = all.subspan(face * texels, texels);
        root[face] = tree.nodes.size();
        if (is_uniform(open))
            tree.faces[face].mean = static_cast<float>(open[0]) / 255;
        else
            add_face(face, open, tree);
    }
    root[cubemap_faces] = tree.nodes.size();
    for (std::size_t face = 0; face < cubemap_faces; ++face)
        tree.faces[face].root = root[face] < root[face + 1] ? &tree.nodes[root[face]] : nullptr;
}

/// Adds nodes by level, so that the children of a node are contiguous.
void TexelTreeMaker::add_face(std::size_t face, std::span<const std::uint8_t> open, TexelTree& tree) {
    sort_into_blocks(open, face_size_, blocks_);
    for (std::size_t level = upper_.size(); level-- > 0;) gather_squares(level);
    tree.faces[face].mean = mean_of(0, 0);
    const std::size_t root = tree.nodes.size();
    tree.nodes.emplace_back();
    paths_.assign(1, 0);
    std::size_t begin = root;
    for (std::size_t level = 0; level < upper_.size(); ++level) {
        const std::size_t end = tree.nodes.size();
        for (std::size_t i = begin; i < end; ++i) fill_node(i, level, paths_[i - root], tree);
        begin = end;
    }
    for (std::size_t i = begin; i < tree.nodes.size(); ++i)
        tree.nodes[i].mean = blocks_.mean[paths_[i - root]];
}

/// Sums the squares of a level from those of the level below.
void TexelTreeMaker::gather_squares(std::size_t level) {
    const VisibilitySquares& below = squares(level + 1);
    VisibilitySquares& here = upper_[level];
    for (std::size_t path = 0; path < here.open.size(); ++path) {
        const std::uint32_t* open = &below.open[path * wide_cells];
        const std::uint8_t* varies = &below.varies[path * wide_cells];
        std::uint32_t sum = 0, differs = 0;
        for (std::size_t cell = 0; cell < wide_cells; ++cell) {
            sum += open[cell];
            differs |= varies[cell] | (open[cell] ^ open[0]);
        }
        here.open[path] = sum;
        here.varies[path] = differs != 0;
    }
}

/// Fills in a node above the last level and appends its children.
void TexelTreeMaker::fill_node(std::size_t index, std::size_t level, std::size_t path, TexelTree& tree) {
    WideNode<std::uint8_t> node;
    node.first_child = static_cast<std::uint32_t>(tree.nodes.size() - index);
    const VisibilitySquares& below = squares(level + 1);
    for (unsigned cell = 0; cell < wide_cells; ++cell) {
        const std::size_t child = path * wide_cells + cell;
        node.mean[cell] = in_bytes(mean_of(level + 1, child));
        if (below.varies[child] == 0) continue;
        node.varying |= static_cast<std::uint16_t>(1u << cell);
        tree.nodes.emplace_back();
        paths_.push_back(child);
    }
    tree.nodes[index] = node;
}

float TexelTreeMaker::mean_of(std::size_t level, std::size_t path) {
    const std::size_t cells = std::size_t(1) << (4 * (upper_.size() + 1 - level));
    return static_cast<float>(squares(level).open[path]) / static_cast<float>(255 * cells);
}

}  // namespace haarfield
