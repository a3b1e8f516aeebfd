#pragma once
/// Many cubemaps of visibility in little memory: quantised nodes, with equal faces stored once.

#include "fields/base/shared_array.h"
#include "fields/wavelets/quadtree.h"

#include <compare>
#include <memory>
#include <string>

namespace haarfield {

/// Wavelets are stored in these steps, as signed bytes: the largest wavelet, 1/2 where half a square is open,
/// has 127 of them.
inline constexpr float wavelet_step = 0.5f / 127;

/// A face's tree: where its nodes are, and its mean.
struct PackedFace {
    std::uint32_t first_byte = 0;  ///< Of its nodes, in QuadtreePool::node_bytes.
    std::uint16_t node_count = 0;  ///< 0: constant.
    std::uint16_t scaling = 0;     ///< Mean, as an IEEE half float.

    auto operator<=>(const PackedFace&) const = default;  ///< By its numbers, in their order.
};
static_assert(sizeof(PackedFace) == 8);

/// Face indices of one cubemap.
using PackedCubemap = std::array<std::uint32_t, cubemap_faces>;

/// Cubemaps by handle: the index in `cubemaps`. Equal cubemaps and equal faces are stored once.
///
/// The nodes of a face follow each other as in BasicQuadtree, so that masks alone tell where children are:
/// those of the first node that has any begin at 1, those of each later one where the ones before it end. A
/// node is one byte (bits 0 to 3: quadrants that have a child; 4 to 6: wavelets along x, along y, diagonal
/// that are not zero), then one byte for each of these wavelets. After truncation most nodes have one or two.
struct QuadtreePool {
    int face_size = 64;  ///< Texels along an edge that the trees were made from.
    SharedArray<std::uint8_t> node_bytes;
    SharedArray<PackedFace> faces;
    SharedArray<PackedCubemap> cubemaps;
};

/// The trees of one cubemap, packed.
struct PackedTrees {
    std::array<PackedFace, cubemap_faces> faces;
    std::vector<std::uint8_t> node_bytes;  ///< Face by face.
};

/// Rounds wavelets to wavelet_step and means to half floats; subtrees of wavelets that round to zero are left
/// out.
///
/// tree    of visibility: wavelets in [-1/2, 1/2] (asserted).
/// packed  the result; its memory is reused.
void pack_trees(const CubemapTree& tree, PackedTrees& packed);

/// The trees of a pool's cubemap, as they were packed. The pool must be without defect.
///
/// packed  the result; its memory is reused.
void take_trees(const QuadtreePool& pool, std::int32_t handle, PackedTrees& packed);

/// Adds cubemaps in the order of the calls; the handles and the pool depend on that order alone.
class QuadtreePoolBuilder {
public:
    explicit QuadtreePoolBuilder(int face_size);  ///< face_size: texels along an edge.
    ~QuadtreePoolBuilder();

    /// A cubemap's handle; an equal one that was added before is returned again. Not once the pool is full
    /// (asserted).
    std::int32_t add(const PackedTrees& cubemap);

    /// Whether the nodes so far fill 4 GiB, which is as far as faces can point.
    bool is_full() const;

    QuadtreePool finish() &&;  ///< The pool of all cubemaps so far.

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Nodes of all faces.
std::uint64_t node_count(const QuadtreePool& pool);

/// Tree of one face, in floats; reuses the tree's memory.
void unpack_face(const QuadtreePool& pool, std::uint32_t face, Quadtree& tree);

/// Whether every index in the pool is in range, every mean finite, and every face a tree all of whose nodes
/// are reached, none below the texels, so that walking it is safe and ends. Empty if so; otherwise what is
/// wrong, and where.
///
/// cost  O(pool).
std::string pool_defect(const QuadtreePool& pool);

}  // namespace haarfield
