#include "fields/quadtree_pool.h"

#include <Imath/half.h>
#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <cassert>
#include <unordered_map>
#include <utility>

namespace haarfield {
namespace {

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

struct CubemapHash {
    std::size_t operator()(const PackedCubemap& cubemap) const {
        return XXH3_64bits(cubemap.data(), sizeof cubemap);
    }
};

}  // namespace

struct QuadtreePoolBuilder::State {
    int face_size = 0;
    std::vector<PackedNode> nodes;
    std::vector<PackedFace> faces;
    std::vector<PackedCubemap> cubemaps;
    std::unordered_multimap<std::uint64_t, std::uint32_t> face_by_content;
    std::unordered_map<PackedCubemap, std::int32_t, CubemapHash> handle_by_faces;
    std::vector<PackedNode> packed;  ///< Of the face at hand.

    std::uint32_t add_face(const Quadtree& tree) {
        assert(tree.nodes.size() <= std::size_t(packed_face_nodes));
        packed.resize(tree.nodes.size());
        for (std::size_t i = 0; i < packed.size(); ++i) {
            const Quadtree::Node& node = tree.nodes[i];
            for (std::size_t a = 0; a < 3; ++a) packed[i].wavelet[a] = packed_half(node.wavelet[a]);
            packed[i].children = static_cast<std::uint16_t>(node.children);
        }
        PackedFace face;
        face.node_count = static_cast<std::uint16_t>(packed.size());
        face.scaling = packed_half(tree.scaling);

        const std::uint64_t content =
            XXH3_64bits_withSeed(packed.data(), packed.size() * sizeof(PackedNode), face.scaling);
        const auto [first, last] = face_by_content.equal_range(content);
        for (auto candidate = first; candidate != last; ++candidate) {
            const PackedFace& known = faces[candidate->second];
            if (known.scaling == face.scaling && known.node_count == face.node_count &&
                std::equal(packed.begin(), packed.end(), nodes.begin() + known.first_node))
                return candidate->second;
        }
        face.first_node = static_cast<std::uint32_t>(nodes.size());
        nodes.insert(nodes.end(), packed.begin(), packed.end());
        faces.push_back(face);
        const auto index = static_cast<std::uint32_t>(faces.size() - 1);
        face_by_content.emplace(content, index);
        return index;
    }
};

QuadtreePoolBuilder::QuadtreePoolBuilder(int face_size) : state_(new State) {
    state_->face_size = face_size;
}

QuadtreePoolBuilder::~QuadtreePoolBuilder() = default;

std::int32_t QuadtreePoolBuilder::add(const CubemapTree& tree) {
    PackedCubemap cubemap;
    for (std::size_t face = 0; face < cubemap_faces; ++face)
        cubemap[face] = state_->add_face(tree.faces[face]);
    const auto next = static_cast<std::int32_t>(state_->cubemaps.size());
    const auto [entry, is_new] = state_->handle_by_faces.emplace(cubemap, next);
    if (is_new) state_->cubemaps.push_back(cubemap);
    return entry->second;
}

QuadtreePool QuadtreePoolBuilder::finish() && {
    state_->nodes.shrink_to_fit();
    return {state_->face_size, std::move(state_->nodes), std::move(state_->faces),
            std::move(state_->cubemaps)};
}

void unpack_face(const QuadtreePool& pool, std::uint32_t face, Quadtree& tree) {
    const PackedFace& packed = pool.faces[face];
    tree.scaling = unpacked_half(packed.scaling);
    tree.nodes.resize(packed.node_count);
    const PackedNode* node = pool.nodes.data() + packed.first_node;
    for (Quadtree::Node& unpacked : tree.nodes) {
        for (std::size_t a = 0; a < 3; ++a) unpacked.wavelet[a] = unpacked_half(node->wavelet[a]);
        unpacked.children = node->children;
        ++node;
    }
}

Quadtree unpacked_face(const QuadtreePool& pool, std::uint32_t face) {
    Quadtree tree;
    unpack_face(pool, face, tree);
    return tree;
}

std::string pool_defect(const QuadtreePool& pool) {
    if (!is_face_size(pool.face_size))
        return fmt::format("face size is {}; wanted a power of two up to 256", pool.face_size);
    const int levels = std::countr_zero(unsigned(pool.face_size));
    std::vector<int> level;
    for (std::size_t f = 0; f < pool.faces.size(); ++f) {
        const PackedFace& face = pool.faces[f];
        if (face.node_count > packed_face_nodes ||
            std::size_t(face.first_node) + face.node_count > pool.nodes.size())
            return fmt::format("face {} has nodes {} to {}; the pool has {}", f, face.first_node,
                               std::size_t(face.first_node) + face.node_count, pool.nodes.size());
        if (!is_finite_half(face.scaling)) return fmt::format("the mean of face {} is not finite", f);
        if (face.node_count > 0 && levels == 0) return fmt::format("face {} has nodes, on a single texel", f);
        // Children lie level by level in the order of their parents, so one counter tells them all.
        level.assign(face.node_count, 0);
        std::size_t next = 1;
        for (std::size_t i = 0; i < face.node_count; ++i) {
            const PackedNode& node = pool.nodes[face.first_node + i];
            for (const std::uint16_t wavelet : node.wavelet)
                if (!is_finite_half(wavelet))
                    return fmt::format("a wavelet of node {} of face {} is not finite", i, f);
            const unsigned mask = node.children & 15u, first = node.children >> 4;
            if (mask == 0) {
                if (first != 0)
                    return fmt::format("node {} of face {} has no children, but a place for them", i, f);
                continue;
            }
            if (first != next)
                return fmt::format("node {} of face {} has its children at {}; wanted {}", i, f, first, next);
            for (int child = std::popcount(mask); child > 0; --child) {
                if (next >= face.node_count)
                    return fmt::format("node {} of face {} has a child beyond the last node", i, f);
                level[next] = level[i] + 1;
                if (level[next] >= levels)
                    return fmt::format("node {} of face {} lies below the texels", next, f);
                ++next;
            }
        }
        if (face.node_count > 0 && next != face.node_count)
            return fmt::format("face {} has {} nodes; {} are reached", f, face.node_count, next);
    }
    for (std::size_t c = 0; c < pool.cubemaps.size(); ++c)
        for (const std::uint32_t face : pool.cubemaps[c])
            if (face >= pool.faces.size())
                return fmt::format("cubemap {} has face {}; the pool has {}", c, face, pool.faces.size());
    return {};
}

}  // namespace haarfield
