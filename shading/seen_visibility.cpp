#include "shading/seen_visibility.h"

#include <cstring>
#include <limits>

namespace haarfield {
namespace {

/// Where a cell lies in its block, in cells: its number's bits are those of the column and row in turns.
constexpr std::uint32_t cell_column(unsigned cell) {
    return (cell & 1u) | (cell >> 1 & 2u);
}
constexpr std::uint32_t cell_row(unsigned cell) {
    return (cell >> 1 & 1u) | (cell >> 2 & 2u);
}

template <class Word>
bool is_uniform(const std::uint8_t* texels, std::size_t stride, std::uint32_t side) {
    const auto wanted = static_cast<Word>(texels[0] * (std::numeric_limits<Word>::max() / 255));
    Word different = 0;
    for (std::uint32_t row = 0; row < side && different == 0; ++row)
        for (std::uint32_t column = 0; column < side; column += sizeof(Word)) {
            Word word;
            std::memcpy(&word, texels + row * stride + column, sizeof word);
            different |= static_cast<Word>(word ^ wanted);
        }
    return different == 0;
}

/// Whether a square of texels has one value.
bool is_uniform(const std::uint8_t* texels, std::size_t stride, std::uint32_t side) {
    return side <= 1   ? true
           : side == 2 ? is_uniform<std::uint16_t>(texels, stride, side)
           : side == 4 ? is_uniform<std::uint32_t>(texels, stride, side)
                       : is_uniform<std::uint64_t>(texels, stride, side);
}

}  // namespace

const WideCubemap<std::uint8_t>& SeenVisibility::operator()(std::span<const OccluderView> views) {
    const std::span<const std::uint8_t> open = rasterizer_.open_samples(views);
    const auto size = static_cast<std::uint32_t>(face_size_);
    nodes_.clear();
    squares_.clear();
    std::array<std::size_t, cubemap_faces> root;
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        const std::uint8_t* texels = open.data() + face * size * size;
        root[face] = nodes_.size();
        if (is_uniform(texels, size, size))
            faces_[face] = {nullptr, open_fraction(texels[0])};
        else
            add_face(texels);
    }
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        const std::size_t end = face + 1 < cubemap_faces ? root[face + 1] : nodes_.size();
        if (root[face] < end) faces_[face] = {&nodes_[root[face]], squares_[root[face]].mean};
    }
    return faces_;
}

/// Level by level, so that the children of a node lie side by side; then means from the leaves up.
void SeenVisibility::add_face(const std::uint8_t* texels) {
    const std::size_t root = nodes_.size();
    nodes_.emplace_back();
    squares_.push_back({0, 0, 0});
    std::size_t begin = root;
    for (auto side = static_cast<std::uint32_t>(face_size_); begin < nodes_.size(); side /= 4) {
        const std::size_t end = nodes_.size();
        for (std::size_t i = begin; i < end; ++i) fill_node(i, side, texels);
        begin = end;
    }
    for (std::size_t i = nodes_.size(); i-- > root;) {
        WideNode<std::uint8_t>& node = nodes_[i];
        const Square* child = &squares_[i + node.first_child];
        for (unsigned left = node.varying; left != 0; left &= left - 1, ++child) {
            node.mean[unsigned(std::countr_zero(left))] = in_bytes(child->mean);
            squares_[i].mean += child->mean;
        }
        squares_[i].mean *= 1.0f / wide_cells;
    }
}

/// Its mean is then the sum over its constant cells. side: of its square. [texels]
void SeenVisibility::fill_node(std::size_t index, std::uint32_t side, const std::uint8_t* texels) {
    const auto size = static_cast<std::uint32_t>(face_size_);
    Square square = squares_[index];
    WideNode<std::uint8_t> node;
    node.first_child = static_cast<std::uint32_t>(nodes_.size() - index);
    for (unsigned cell = 0; cell < wide_cells; ++cell) {
        // A square of two texels has four cells for each of them.
        const std::uint32_t left = square.left + cell_column(cell) * side / 4,
                            top = square.top + cell_row(cell) * side / 4;
        const std::uint8_t* corner = texels + top * size + left;
        if (is_uniform(corner, size, side / 4)) {
            const float mean = open_fraction(*corner);
            node.mean[cell] = in_bytes(mean);
            square.mean += mean;
        } else {
            node.varying |= static_cast<std::uint16_t>(1u << cell);
            nodes_.emplace_back();
            squares_.push_back({left, top, 0});
        }
    }
    nodes_[index] = node;
    squares_[index] = square;
}

}  // namespace haarfield
