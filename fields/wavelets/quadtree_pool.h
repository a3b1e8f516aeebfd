#pragma once
/// Compact storage of many visibility cubemaps: quantised nodes, with equal faces stored once.

#include "fields/base/shared_array.h"
#include "fields/wavelets/quadtree.h"

#include <compare>
#include <memory>
#include <string>

namespace haarfield {

/// The quantisation step of wavelets, which are stored as signed bytes. The largest wavelet is 1/2 (half of a
/// square is open) and becomes 127.
inline constexpr float wavelet_step = 0.5f / 127;

/// The tree of a face: the location of its nodes, and its mean.
struct PackedFace {
    std::array<std::uint32_t, 2> first{};  ///< first_byte(), low word first: three words without padding.
    std::uint16_t node_count = 0;          ///< 0: constant.
    std::uint16_t scaling = 0;             ///< Mean, as an IEEE half float.

    /// The first byte of its nodes in QuadtreePool::node_bytes.
    std::uint64_t first_byte() const { return std::uint64_t(first[1]) << 32 | first[0]; }
    /// Sets first_byte().
    void set_first_byte(std::uint64_t byte) {
        first = {static_cast<std::uint32_t>(byte), static_cast<std::uint32_t>(byte >> 32)};
    }

    auto operator<=>(const PackedFace&) const = default;  ///< Lexicographic order of the members.
};
static_assert(sizeof(PackedFace) == 12);

/// The face indices of one cubemap.
using PackedCubemap = std::array<std::uint32_t, cubemap_faces>;

/// Cubemaps by handle: the index in `cubemaps`. Equal cubemaps and equal faces are stored once.
///
/// The nodes of a face are in level order, as in BasicQuadtree, so their masks determine the locations of
/// children. The children of the first node that has any begin at index 1; those of each later node follow
/// the children before them. A node is one byte, then one byte for each non-zero wavelet. The first byte
/// holds the quadrants with a child (bits 0 to 3) and the non-zero wavelets along x, along y and diagonal
/// (bits 4 to 6). After truncation most nodes have one or two wavelets.
struct QuadtreePool {
    int face_size = 64;  ///< Texels along an edge of the cubemaps that the trees were made from.
    SharedArray<std::uint8_t> node_bytes;
    SharedArray<PackedFace> faces;
    SharedArray<PackedCubemap> cubemaps;
};

/// The packed trees of one cubemap.
struct PackedTrees {
    std::array<PackedFace, cubemap_faces> faces;
    std::vector<std::uint8_t> node_bytes;  ///< Face by face.
};

/// Packs trees: rounds wavelets to wavelet_step and means to half floats. Drops subtrees in which all
/// wavelets round to zero.
///
/// tree    visibility, with wavelets in [-1/2, 1/2] (asserted).
/// packed  the result; its memory is reused.
void pack_trees(const CubemapTree& tree, PackedTrees& packed);

/// Returns the packed trees of a cubemap of the pool. The pool must have no defect.
///
/// packed  the result; its memory is reused.
void take_trees(const QuadtreePool& pool, std::int32_t handle, PackedTrees& packed);

/// Builds a pool. Handles and pool depend only on the order of the calls.
class QuadtreePoolBuilder {
public:
    explicit QuadtreePoolBuilder(int face_size);  ///< face_size: texels along an edge.
    ~QuadtreePoolBuilder();

    /// Adds a cubemap and returns its handle. Returns the existing handle if an equal cubemap was added
    /// before. The pool must not be full (asserted).
    std::int32_t add(const PackedTrees& cubemap);

    /// True if the faces nearly exhaust their 32-bit numbers.
    bool is_full() const;

    QuadtreePool finish() &&;  ///< Returns the pool of all added cubemaps.

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Returns the handle of the cubemap whose directions are all unoccluded; -1 if the pool has none.
///
/// cost  O(faces + cubemaps).
std::int32_t unoccluded_cubemap(const QuadtreePool& pool);

/// Returns the number of nodes of all faces.
std::uint64_t node_count(const QuadtreePool& pool);

/// Unpacks the tree of one face to floats. Reuses the memory of `tree`.
void unpack_face(const QuadtreePool& pool, std::uint32_t face, Quadtree& tree);

/// Checks that a traversal of the pool is safe and ends: every index is in range, every mean is finite, and
/// the nodes of every face form one tree that does not extend below the texels.
///
/// returns  empty if so; otherwise the defect and its location.
/// cost     O(pool).
std::string pool_defect(const QuadtreePool& pool);

}  // namespace haarfield
