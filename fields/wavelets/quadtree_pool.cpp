#include "fields/wavelets/quadtree_pool.h"

#include <Imath/half.h>
#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>
#include <xxhash.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <unordered_map>
#include <utility>

namespace haarfield {
namespace {

constexpr unsigned children_mask = 15, wavelet_bit = 16;  // in a node's first byte

std::uint8_t packed_wavelet(float value) {
    assert(std::abs(value) <= 0.5f);
    // std::lround is slower: a library call.
    return static_cast<std::uint8_t>(
        static_cast<int>(value * (1 / wavelet_step) + std::copysign(0.5f, value)));
}

float unpacked_wavelet(std::uint8_t byte) {
    return static_cast<float>(static_cast<std::int8_t>(byte)) * wavelet_step;
}

std::uint16_t packed_half(float value) {
    return Imath::half(value).bits();
}

float unpacked_half(std::uint16_t bits) {
    Imath::half value;
    value.setBits(bits);
    return value;
}

bool is_finite_half(std::uint16_t bits) {
    return (bits & 0x7c00u) != 0x7c00u;
}

/// Appends the nodes with a wavelet in them or below them that does not round to zero. Returns their number.
std::size_t append_packed(const Quadtree& tree, std::vector<std::uint8_t>& bytes) {
    struct Node {
        unsigned head;
        std::array<std::uint8_t, 3> wavelet;
    };
    std::array<Node, (256 * 256 - 1) / 3> packed;
    // Children follow their parents, so reverse order visits children first.
    for (std::size_t i = tree.nodes.size(); i-- > 0;) {
        const Quadtree::Node& node = tree.nodes[i];
        packed[i].head = 0;
        for (unsigned kind = 0; kind < 3; ++kind) {
            packed[i].wavelet[kind] = packed_wavelet(node.wavelet[kind]);
            if (packed[i].wavelet[kind] != 0) packed[i].head |= wavelet_bit << kind;
        }
        for (unsigned q = 0; q < 4; ++q)
            if (const std::int32_t child = child_of(node, q);
                child != no_node && packed[std::size_t(child)].head != 0)
                packed[i].head |= 1u << q;
    }
    std::size_t count = 0;
    for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
        if (packed[i].head == 0) continue;
        ++count;
        bytes.push_back(static_cast<std::uint8_t>(packed[i].head));
        for (const std::uint8_t wavelet : packed[i].wavelet)
            if (wavelet != 0) bytes.push_back(wavelet);
    }
    return count;
}

struct CubemapHash {
    std::size_t operator()(const PackedCubemap& cubemap) const {
        return XXH3_64bits(cubemap.data(), sizeof cubemap);
    }
};

}  // namespace

void pack_trees(const CubemapTree& tree, PackedTrees& packed) {
    packed.node_bytes.clear();
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        PackedFace& packed_face = packed.faces[face];
        packed_face.scaling = packed_half(tree.faces[face].scaling);
        packed_face.set_first_byte(packed.node_bytes.size());
        packed_face.node_count =
            static_cast<std::uint16_t>(append_packed(tree.faces[face], packed.node_bytes));
    }
}

struct QuadtreePoolBuilder::State {
    int face_size = 0;
    std::vector<std::uint8_t> node_bytes;
    std::vector<PackedFace> faces;
    std::vector<PackedCubemap> cubemaps;
    std::unordered_multimap<std::uint64_t, std::uint32_t> face_by_content;
    std::unordered_map<PackedCubemap, std::int32_t, CubemapHash> handle_by_faces;

    std::uint32_t add_face(PackedFace face, std::span<const std::uint8_t> bytes) {
        const std::uint64_t content = XXH3_64bits_withSeed(bytes.data(), bytes.size(), face.scaling);
        const auto [first, last] = face_by_content.equal_range(content);
        for (auto candidate = first; candidate != last; ++candidate) {
            const PackedFace& known = faces[candidate->second];
            // A face with as many nodes and the same first bytes has no further bytes.
            if (known.scaling == face.scaling && known.node_count == face.node_count &&
                bytes.size() <= node_bytes.size() - known.first_byte() &&
                std::equal(bytes.begin(), bytes.end(),
                           node_bytes.begin() + std::ptrdiff_t(known.first_byte())))
                return candidate->second;
        }
        face.set_first_byte(node_bytes.size());
        node_bytes.insert(node_bytes.end(), bytes.begin(), bytes.end());
        const auto index = static_cast<std::uint32_t>(faces.size());
        faces.push_back(face);
        face_by_content.emplace(content, index);
        return index;
    }
};

QuadtreePoolBuilder::QuadtreePoolBuilder(int face_size) : state_(new State) {
    state_->face_size = face_size;
}

QuadtreePoolBuilder::~QuadtreePoolBuilder() = default;

std::int32_t QuadtreePoolBuilder::add(const PackedTrees& trees) {
    PackedCubemap cubemap;
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        const std::size_t first = trees.faces[face].first_byte(),
                          last = face + 1 < cubemap_faces ? trees.faces[face + 1].first_byte()
                                                          : trees.node_bytes.size();
        cubemap[face] =
            state_->add_face(trees.faces[face], std::span(trees.node_bytes).subspan(first, last - first));
    }
    const auto next = static_cast<std::int32_t>(state_->cubemaps.size());
    const auto [entry, is_new] = state_->handle_by_faces.emplace(cubemap, next);
    if (is_new) state_->cubemaps.push_back(cubemap);
    return entry->second;
}

bool QuadtreePoolBuilder::is_full() const {
    // Reserves numbers for the other faces of a cubemap and for the remaining cubemaps of a chunk.
    constexpr std::uint64_t room = std::uint64_t(1) << 26;
    return state_->faces.size() > 0xffffffffu - room;
}

QuadtreePool QuadtreePoolBuilder::finish() && {
    state_->node_bytes.shrink_to_fit();
    return {state_->face_size, std::move(state_->node_bytes), std::move(state_->faces),
            std::move(state_->cubemaps)};
}

std::int32_t unoccluded_cubemap(const QuadtreePool& pool) {
    std::vector<bool> is_open(pool.faces.size());
    const std::uint16_t one = packed_half(1);
    for (std::size_t f = 0; f < is_open.size(); ++f)
        is_open[f] = pool.faces[f].node_count == 0 && pool.faces[f].scaling == one;
    for (std::size_t c = 0; c < pool.cubemaps.size(); ++c)
        if (std::ranges::all_of(pool.cubemaps[c],
                                [&](std::uint32_t face) { return face < is_open.size() && is_open[face]; }))
            return static_cast<std::int32_t>(c);
    return -1;
}

std::uint64_t node_count(const QuadtreePool& pool) {
    std::uint64_t count = 0;
    for (const PackedFace& face : pool.faces) count += face.node_count;
    return count;
}

void unpack_face(const QuadtreePool& pool, std::uint32_t face, Quadtree& tree) {
    const PackedFace& packed = pool.faces[face];
    tree.scaling = unpacked_half(packed.scaling);
    tree.nodes.resize(packed.node_count);
    const std::uint8_t* byte = pool.node_bytes.data() + packed.first_byte();
    std::uint32_t next = 1;
    for (Quadtree::Node& node : tree.nodes) {
        const unsigned head = *byte++, children = head & children_mask;
        for (unsigned kind = 0; kind < 3; ++kind)
            node.wavelet[kind] = head & wavelet_bit << kind ? unpacked_wavelet(*byte++) : 0;
        node.children = children == 0 ? 0 : next << 4 | children;
        next += quadrant_count(children);
    }
}

namespace {

/// The decoded first byte of a node. A table, because millions of nodes are checked whenever a field is read.
struct NodeHead {
    std::uint8_t children = 0, bytes = 0;  ///< bytes: size of the node; 0 if the first byte is invalid.
};

constexpr std::array<NodeHead, 256> node_heads = [] {
    std::array<NodeHead, 256> heads{};
    for (unsigned byte = 0; byte < wavelet_bit << 3; ++byte)
        heads[byte] = {static_cast<std::uint8_t>(std::popcount(byte & children_mask)),
                       static_cast<std::uint8_t>(1 + std::popcount(byte / wavelet_bit))};
    return heads;
}();

/// Reads the nodes of a face level by level. True if they form one tree within `levels` levels and the bytes.
bool is_whole_tree(std::span<const std::uint8_t> bytes, std::size_t nodes, int levels) {
    std::size_t at = 0, begin = 0, end = 1;  // byte; nodes of the level
    for (int level = 0; begin < nodes; ++level) {
        if (level == levels || end > nodes || begin == end) return false;
        std::size_t children = 0;
        for (; begin < end; ++begin) {
            if (at >= bytes.size()) return false;
            const NodeHead head = node_heads[bytes[at]];
            if (head.bytes == 0) return false;
            children += head.children;
            at += head.bytes;
        }
        end += children;
    }
    return end == nodes && at <= bytes.size();
}

std::string face_defect(const QuadtreePool& pool, std::size_t f, int levels) {
    const PackedFace& face = pool.faces[f];
    if (!is_finite_half(face.scaling)) return fmt::format("the mean of face {} is not finite", f);
    if (face.first_byte() > pool.node_bytes.size())
        return fmt::format("face {} begins at byte {}; the pool has {}", f, face.first_byte(),
                           pool.node_bytes.size());
    if (face.node_count > 0 && !is_whole_tree(std::span(pool.node_bytes.data() + face.first_byte(),
                                                        pool.node_bytes.size() - face.first_byte()),
                                              face.node_count, levels))
        return fmt::format("the nodes of face {} are not a tree of at most {} levels", f, levels);
    return {};
}

}  // namespace

void take_trees(const QuadtreePool& pool, std::int32_t handle, PackedTrees& packed) {
    packed.node_bytes.clear();
    const PackedCubemap& cubemap = pool.cubemaps[static_cast<std::size_t>(handle)];
    for (std::size_t f = 0; f < cubemap_faces; ++f) {
        const PackedFace& face = pool.faces[cubemap[f]];
        packed.faces[f] = face;
        packed.faces[f].set_first_byte(packed.node_bytes.size());
        const std::uint8_t* const begin = pool.node_bytes.data() + face.first_byte();
        const std::uint8_t* end = begin;
        for (unsigned node = 0; node < face.node_count; ++node) end += node_heads[*end].bytes;
        packed.node_bytes.insert(packed.node_bytes.end(), begin, end);
    }
}

std::string pool_defect(const QuadtreePool& pool) {
    if (!is_face_size(pool.face_size))
        return fmt::format("face size is {}; expected a power of two up to 256", pool.face_size);
    const int levels = std::countr_zero(unsigned(pool.face_size));
    // The first defective face, whichever thread finds it.
    const std::size_t first = tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, pool.faces.size(), 1024), pool.faces.size(),
        [&](const auto& range, std::size_t found) {
            for (std::size_t f = range.begin(); f < std::min(range.end(), found); ++f)
                if (!face_defect(pool, f, levels).empty()) return f;
            return found;
        },
        [](std::size_t a, std::size_t b) { return std::min(a, b); });
    if (first < pool.faces.size()) return face_defect(pool, first, levels);
    for (std::size_t c = 0; c < pool.cubemaps.size(); ++c)
        for (const std::uint32_t face : pool.cubemaps[c])
            if (face >= pool.faces.size())
                return fmt::format("cubemap {} has face {}; the pool has {}", c, face, pool.faces.size());
    return {};
}

}  // namespace haarfield
