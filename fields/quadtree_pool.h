#pragma once
/// Many cubemaps of visibility in little memory: packed nodes, with equal faces stored once.

#include "fields/quadtree.h"
#include "fields/shared_array.h"

#include <compare>
#include <memory>
#include <string>

namespace haarfield {

/// A quadtree node in eight bytes.
struct PackedNode {
    std::array<std::uint16_t, 3> wavelet{};  ///< Amplitudes as IEEE half floats, as in BasicQuadtree::Node.
    std::uint16_t children = 0;              ///< First child, from the face's first node, << 4 | mask.

    auto operator<=>(const PackedNode&) const = default;
};
static_assert(sizeof(PackedNode) == 8);

struct PackedFace {
    std::uint32_t first_node = 0;  ///< In QuadtreePool::nodes.
    std::uint16_t node_count = 0;  ///< 0: constant. At most packed_face_nodes.
    std::uint16_t scaling = 0;     ///< Mean, as an IEEE half float.

    auto operator<=>(const PackedFace&) const = default;
};
static_assert(sizeof(PackedFace) == 8);

/// Twelve bits address a child.
inline constexpr int packed_face_nodes = 4096;

/// Face indices of one cubemap.
using PackedCubemap = std::array<std::uint32_t, cubemap_faces>;

/// Cubemaps by handle: the index in `cubemaps`. Equal cubemaps and equal faces are stored once.
struct QuadtreePool {
    int face_size = 64;  ///< Texels along an edge that the trees were made from.
    SharedArray<PackedNode> nodes;
    SharedArray<PackedFace> faces;
    SharedArray<PackedCubemap> cubemaps;
};

/// Adds cubemaps in the order of the calls; the handles and the pool depend on that order alone.
class QuadtreePoolBuilder {
public:
    explicit QuadtreePoolBuilder(int face_size);
    ~QuadtreePoolBuilder();

    /// A cubemap's handle; an equal one that was added before is returned again. Each face has at most
    /// packed_face_nodes nodes (asserted). Amplitudes are rounded to half floats.
    std::int32_t add(const CubemapTree& tree);

    QuadtreePool finish() &&;

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Tree of one face, in floats; `unpack_face` reuses the tree's memory.
void unpack_face(const QuadtreePool& pool, std::uint32_t face, Quadtree& tree);
Quadtree unpacked_face(const QuadtreePool& pool, std::uint32_t face);

/// Whether every index in the pool is in range and every face is a tree whose nodes come parents
/// first and are all reached, level by level and without gaps, so that walking it is safe and ends. Empty if
/// so; otherwise what is wrong, and where.
std::string pool_defect(const QuadtreePool& pool);

}  // namespace haarfield
