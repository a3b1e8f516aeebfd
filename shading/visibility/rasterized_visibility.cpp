#include "shading/visibility/rasterized_visibility.h"

#include <algorithm>
#include <cstring>

namespace haarfield {
namespace {

bool is_uniform(std::span<const std::uint8_t> open) {
    return std::memcmp(open.data(), open.data() + 1, open.size() - 1) == 0;
}

/// Converts a number of unoccluded samples to visibility. [1/255]
constexpr std::uint8_t open_in_bytes(std::uint8_t count) {
    return static_cast<std::uint8_t>(32 * count - (count + 3) / 8);
}
static_assert([] {
    for (std::uint8_t count = 0; count <= samples_per_texel; ++count)
        if (open_in_bytes(count) != in_bytes(open_fraction(count))) return false;
    return true;
}());

}  // namespace

RasterizedVisibility::RasterizedVisibility(int face_size)
    : face_size_(face_size),
      rasterizer_(face_size),
      open_(std::size_t(cubemap_faces * face_size) * std::size_t(face_size)),
      upper_(static_cast<std::size_t>(std::max(wide_levels(face_size), 1)) - 1) {
    for (std::size_t level = 0; level < upper_.size(); ++level) {
        upper_[level].open.resize(std::size_t(1) << (4 * level));
        upper_[level].varies.resize(std::size_t(1) << (4 * level));
    }
}

std::span<std::uint8_t> RasterizedVisibility::texels(std::span<const OccluderView> views) {
    if (views.empty()) {
        std::ranges::fill(open_, std::uint8_t(255));
    } else {
        const std::span<const std::uint8_t> counts = rasterizer_.open_samples(views);
        std::ranges::transform(counts, open_.begin(), open_in_bytes);
    }
    return open_;
}

const WideCubemap<std::uint8_t>& RasterizedVisibility::tree() {
    const std::size_t texels = open_.size() / cubemap_faces;
    nodes_.clear();
    std::array<std::size_t, cubemap_faces + 1> root{};
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        const std::span<const std::uint8_t> open = std::span(open_).subspan(face * texels, texels);
        root[face] = nodes_.size();
        if (is_uniform(open))
            faces_[face].mean = static_cast<float>(open[0]) / 255;
        else
            add_face(face, open);
    }
    root[cubemap_faces] = nodes_.size();
    for (std::size_t face = 0; face < cubemap_faces; ++face)
        faces_[face].root = root[face] < root[face + 1] ? &nodes_[root[face]] : nullptr;
    return faces_;
}

/// Adds nodes by level, so that the children of a node are contiguous.
void RasterizedVisibility::add_face(std::size_t face, std::span<const std::uint8_t> open) {
    sort_into_blocks(open, face_size_, blocks_);
    for (std::size_t level = upper_.size(); level-- > 0;) gather_squares(level);
    faces_[face].mean = mean_of(0, 0);
    const std::size_t root = nodes_.size();
    nodes_.emplace_back();
    paths_.assign(1, 0);
    std::size_t begin = root;
    for (std::size_t level = 0; level < upper_.size(); ++level) {
        const std::size_t end = nodes_.size();
        for (std::size_t i = begin; i < end; ++i) fill_node(i, level, paths_[i - root]);
        begin = end;
    }
    for (std::size_t i = begin; i < nodes_.size(); ++i) nodes_[i].mean = blocks_.mean[paths_[i - root]];
}

/// Sums the squares of a level from those of the level below.
void RasterizedVisibility::gather_squares(std::size_t level) {
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
void RasterizedVisibility::fill_node(std::size_t index, std::size_t level, std::size_t path) {
    WideNode<std::uint8_t> node;
    node.first_child = static_cast<std::uint32_t>(nodes_.size() - index);
    const VisibilitySquares& below = squares(level + 1);
    for (unsigned cell = 0; cell < wide_cells; ++cell) {
        const std::size_t child = path * wide_cells + cell;
        node.mean[cell] = in_bytes(mean_of(level + 1, child));
        if (below.varies[child] == 0) continue;
        node.varying |= static_cast<std::uint16_t>(1u << cell);
        nodes_.emplace_back();
        paths_.push_back(child);
    }
    nodes_[index] = node;
}

float RasterizedVisibility::mean_of(std::size_t level, std::size_t path) {
    const std::size_t cells = std::size_t(1) << (4 * (upper_.size() + 1 - level));
    return static_cast<float>(squares(level).open[path]) / static_cast<float>(255 * cells);
}

}  // namespace haarfield
