#pragma once
/// A mesh as something that blocks light: triangles, and which of them may be seen from behind.

#include "fields/base/rotation.h"
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

/// What an occluder is made from.
///
/// A closed piece (every edge shared by exactly two triangles that agree in orientation, positive
/// volume) blocks with its front faces only: from outside the union of the pieces that is the whole
/// truth, and a point slightly under a simplified surface is not darkened by its inside. Any other
/// piece blocks with both sides.
struct OccluderTriangles {
    std::vector<Vec3f> positions;                         ///< [m]
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< One-sided first, then two-sided.
    std::uint32_t one_sided = 0;                          ///< How many of them are one-sided.
    Bounds bounds;                                        ///< Of all positions that there were. [m]
};

/// Triangles ready for the visibility rasterizer: with what it wants to have at hand, which is derived from
/// them when the occluder is made, and follows no change but that of the whole.
class Occluder {
public:
    /// Blocks nothing.
    Occluder() : Occluder(OccluderTriangles()) {}
    /// cost  O(n log n) in the triangles.
    explicit Occluder(OccluderTriangles source);

    const OccluderTriangles& source() const { return source_; }  ///< What it is made from:
    /// OccluderTriangles::positions,
    const std::vector<Vec3f>& positions() const { return source_.positions; }
    /// OccluderTriangles::triangles,
    const std::vector<std::array<std::uint32_t, 3>>& triangles() const { return source_.triangles; }
    std::uint32_t one_sided() const { return source_.one_sided; }  ///< OccluderTriangles::one_sided,
    const Bounds& bounds() const { return source_.bounds; }        ///< OccluderTriangles::bounds.

    /// x, y, z, 0 of each position, and of a vector more.
    const std::vector<float>& padded_positions() const { return padded_positions_; }
    const OccluderPlanes& planes() const { return planes_; }         ///< Of the triangles.
    const OccluderEdges& edges() const { return edges_; }            ///< Of most pieces, by clusters.
    const std::array<AxisGrid, 3>& grids() const { return grids_; }  ///< Of the triangles, by axis.

private:
    OccluderTriangles source_;
    std::vector<float> padded_positions_;
    OccluderPlanes planes_;
    OccluderEdges edges_;
    std::array<AxisGrid, 3> grids_;
};

/// The same, turned about the origin.
///
/// cost  some 1 ms per 5,000 triangles.
Occluder turned_occluder(const Occluder& occluder, const Rotation& rotation);

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
