#include "shading/walk/wavelet_blocks.h"

#include <algorithm>
#include <cassert>
#include <limits>

namespace haarfield {

namespace {

constexpr std::uint32_t no_block = std::numeric_limits<std::uint32_t>::max();

/// Indices of the child blocks of each block, by cell.
using BlocksBelow = std::vector<std::array<std::uint32_t, wide_cells>>;

template <class Value, int channels>
Value amplitude(const WaveletBlock<channels>& block, std::size_t slot) {
    if constexpr (channels == 1)
        return block.amplitude[0][slot];
    else
        return Value(block.amplitude[0][slot], block.amplitude[1][slot], block.amplitude[2][slot]);
}

/// A square that becomes a node: that of a block, or one of its quadrants.
struct Square {
    static constexpr unsigned own = 4;

    std::uint32_t block;
    unsigned quadrant;

    /// Slots of its wavelets: the first, and the distance between them.
    std::size_t first_slot() const { return quadrant == own ? 4 : 4 * quadrant + 1; }
    std::size_t slot_step() const { return quadrant == own ? 4 : 1; }
};

template <class Value, int channels>
std::array<Value, 3> wavelets(const WaveletBlock<channels>& block, const Square& square) {
    std::array<Value, 3> result;
    for (std::size_t k = 0; k < 3; ++k)
        result[k] = amplitude<Value>(block, square.first_slot() + k * square.slot_step());
    return result;
}

template <class Value, int channels>
class TreeWriter {
public:
    explicit TreeWriter(std::span<const WaveletBlock<channels>> product) : product_(product) {
        below_.resize(product.size());
        for (auto& blocks : below_) blocks.fill(no_block);
        for (std::uint32_t i = 0; i < product.size(); ++i)
            if (product[i].parent != i) below_[product[i].parent][product[i].cell] = i;
    }

    /// Builds the tree of a face, breadth first: `squares` lists the squares of the nodes made so far.
    BasicQuadtree<Value> face(std::uint32_t root) const {
        BasicQuadtree<Value> tree;
        tree.scaling = amplitude<Value>(product_[root], 0);
        std::vector<Square> squares;
        const auto add = [&](const Square& square) {
            squares.push_back(square);
            tree.nodes.push_back({wavelets<Value>(product_[square.block], square), 0});
        };
        if (is_needed({root, Square::own})) add({root, Square::own});
        for (std::size_t i = 0; i < squares.size(); ++i) {
            const auto first = static_cast<std::uint32_t>(squares.size());
            std::uint32_t mask = 0;
            for (unsigned q = 0; q < 4; ++q)
                if (const Square child = quadrant_of(squares[i], q); is_needed(child)) {
                    add(child);
                    mask |= 1u << q;
                }
            if (mask != 0) tree.nodes[i].children = first << 4 | mask;
        }
        return tree;
    }

private:
    Square quadrant_of(const Square& square, unsigned q) const {
        if (square.quadrant == Square::own) return {square.block, q};
        return {below_[square.block][4 * square.quadrant + q], Square::own};
    }
    bool is_needed(const Square& square) const {
        if (square.block == no_block) return false;
        const auto all = wavelets<Value>(product_[square.block], square);
        if (std::ranges::any_of(all, [](const Value& w) { return w != Value(0.0f); })) return true;
        for (unsigned q = 0; q < 4; ++q)
            if (is_needed(quadrant_of(square, q))) return true;
        return false;
    }

    std::span<const WaveletBlock<channels>> product_;
    BlocksBelow below_;
};

template <class Value, int channels>
BasicCubemapTree<Value> trees_of(std::span<const WaveletBlock<channels>> product) {
    const TreeWriter<Value, channels> writer(product);
    BasicCubemapTree<Value> result;
    [[maybe_unused]] std::size_t faces = 0;
    for (std::uint32_t i = 0; i < product.size(); ++i) {
        if (product[i].parent != i) continue;
        assert(product[i].block < cubemap_faces);
        result.faces[product[i].block] = writer.face(i);
        ++faces;
    }
    assert(faces == cubemap_faces);
    return result;
}

}  // namespace

CubemapTree cubemap_tree(std::span<const WaveletBlock<1>> product) {
    return trees_of<float>(product);
}

RgbCubemapTree cubemap_tree(std::span<const WaveletBlock<3>> product) {
    return trees_of<Rgb>(product);
}

}  // namespace haarfield
