#pragma once
/// A mesh as something that blocks light: triangles, and which of them may be seen from behind.

#include "fields/mesh/mesh.h"
#include "fields/mesh/occluder_edges.h"

#include <span>

namespace haarfield {

/// Triangles by the cell of the plane across an axis that their boxes touch.
struct AxisGrid {
    int cells = 1;  ///< Along an edge.
    std::array<float, 2> lower{}, cells_per_metre{};
    std::vector<std::uint32_t> first, triangle;  ///< Cell c has triangle[first[c]] to [first[c + 1] - 1].

    /// Of a coordinate across the axis (k = 0) or up (k = 1).
    int cell(float coordinate, std::size_t k) const;
    /// All triangles whose images along the axis may contain a point.
    std::span<const std::uint32_t> triangles_at(float across, float up) const;
};

/// By the axis x, y, z: the axes across it and up, a right-handed frame with it.
struct AxisFrame {
    int across, up;
};
inline constexpr std::array<AxisFrame, 3> axis_frames{{{1, 2}, {2, 0}, {0, 1}}};  ///< Of x, y and z.

/// Triangles ready for the visibility rasterizer.
///
/// A closed piece (every edge shared by exactly two triangles that agree in orientation, positive
/// volume) blocks with its front faces only: from outside the union of the pieces that is the whole
/// truth, and a point slightly under a simplified surface is not darkened by its inside. Any other
/// piece blocks with both sides.
struct Occluder {
    std::vector<Vec3f> positions;                         ///< [m]
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< One-sided first, then two-sided.
    std::uint32_t one_sided = 0;                          ///< How many of them are one-sided.
    Bounds bounds;

    // What follows is derived from it by prepare_occluder.
    std::vector<float> padded_positions;  ///< x, y, z, 0 of each, and of a vector more.
    SoaPlanes planes;                     ///< Padded to multiples of 64.
    Vec3d planes_centre;
    OccluderEdges edges;
    std::array<AxisGrid, 3> grids;  ///< By axis.
};

/// Fills what the rasterizer wants to have at hand; needed after any change to the triangles or positions.
void prepare_occluder(Occluder& occluder);

/// From any mesh; normals and materials do not matter. Equal positions are merged first.
Occluder make_occluder(const Mesh& mesh);

/// Tells whether a point lies inside the closed (one-sided) pieces of an occluder: whether their winding
/// number there is positive. Safe to share between threads.
///
/// accuracy  the majority of three axis-parallel rays; right but for points within some 1e-6 radii of the
///           surface.
/// cost      O(triangles in one column) a query, through the occluder's grids.
class InsideTest {
public:
    /// The occluder must outlive the test.
    explicit InsideTest(const Occluder& occluder);

    bool operator()(const Vec3f& point) const;  ///< Whether the point lies inside.

private:
    const Occluder& occluder_;
};

}  // namespace haarfield
