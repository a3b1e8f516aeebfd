#pragma once
/// A mesh that blocks light: triangles, and which of them are visible from behind.

#include "fields/base/rotation.h"
#include "fields/mesh/mesh.h"
#include "fields/occluder/axis_grid.h"
#include "fields/occluder/occluder_edges.h"

namespace haarfield {

/// The data that an occluder is made from.
///
/// A closed piece (positive volume, every edge shared by exactly two consistently oriented triangles) blocks
/// only with its front faces. From outside all pieces this is exact, and a point slightly below a simplified
/// surface is not darkened by its inside. Any other piece blocks with both sides.
struct OccluderTriangles {
    std::vector<Vec3f> positions;                         ///< [m]
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< One-sided first, then two-sided.
    std::uint32_t one_sided = 0;                          ///< The number of one-sided triangles.
    Bounds bounds;                                        ///< Bounds of all positions of the mesh. [m]
};

/// The purpose of an occluder.
enum class OccluderUse {
    rasterized,    ///< Everything.
    inside_tests,  ///< Rays and inside tests only: no padded positions, planes and edges.
};

/// An immutable set of triangles with the data that the visibility rasterizer derives from them.
class Occluder {
public:
    /// Creates an occluder that blocks nothing.
    Occluder() : Occluder(OccluderTriangles()) {}
    /// cost  O(n log n) in the triangles.
    explicit Occluder(OccluderTriangles source, OccluderUse use = OccluderUse::rasterized);

    const OccluderTriangles& source() const { return source_; }  ///< The data that it is made from.
    /// OccluderTriangles::positions.
    const std::vector<Vec3f>& positions() const { return source_.positions; }
    /// OccluderTriangles::triangles.
    const std::vector<std::array<std::uint32_t, 3>>& triangles() const { return source_.triangles; }
    std::uint32_t one_sided() const { return source_.one_sided; }  ///< OccluderTriangles::one_sided.
    const Bounds& bounds() const { return source_.bounds; }        ///< OccluderTriangles::bounds.

    /// x, y, z, 0 of each position, padded by one vector.
    const std::vector<float>& padded_positions() const { return padded_positions_; }
    const OccluderPlanes& planes() const { return planes_; }  ///< The triangles' planes.
    const OccluderEdges& edges() const { return edges_; }     ///< Edges of most pieces, in clusters.
    /// The triangles, projected along x, y and z.
    const std::array<AxisGrid, 3>& grids() const { return grids_; }

private:
    OccluderTriangles source_;
    std::vector<float> padded_positions_;
    OccluderPlanes planes_;
    OccluderEdges edges_;
    std::array<AxisGrid, 3> grids_;
};

/// Returns an occluder rotated about the origin.
///
/// cost  about 1 ms per 5,000 triangles.
Occluder turned_occluder(const Occluder& occluder, const Rotation& rotation);

/// Returns the triangles of any mesh. Normals and materials are ignored. Equal positions are merged first.
OccluderTriangles occluder_triangles(const Mesh& mesh);

/// Makes an occluder of occluder_triangles.
Occluder make_occluder(const Mesh& mesh);

/// Tests whether a point is inside the closed (one-sided) pieces of an occluder: their winding number there
/// is positive. Safe to share between threads.
///
/// accuracy  the majority of three axis-parallel rays; correct except within about 1e-6 radii of the surface.
/// cost      O(triangles in one column) per query, using the occluder's grids.
class InsideTest {
public:
    /// The occluder must outlive the test.
    explicit InsideTest(const Occluder& occluder);

    bool operator()(const Vec3f& point) const;  ///< True if the point is inside.

private:
    const Occluder& occluder_;
};

}  // namespace haarfield
