#pragma once
/// A mesh as something that blocks light: triangles, and which of them may be seen from behind.

#include "fields/base/rotation.h"
#include "fields/mesh/mesh.h"
#include "fields/occluder/axis_grid.h"
#include "fields/occluder/occluder_edges.h"

namespace haarfield {

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
