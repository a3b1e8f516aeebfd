#pragma once
/// A mesh as something that blocks light: triangles, and which of them may be seen from behind.

#include "fields/mesh.h"

namespace haarfield {

/// Points by coordinate, padded to whole vectors. [m]
struct SoaPoints {
    std::vector<float> x, y, z;
};

/// Planes of triangles by coordinate, padded to multiples of 64 (with planes that nothing is in front of). A
/// point p is in front where  (x, y, z) . (p - centre) > offset;  (x, y, z) is a unit vector, or zero for a
/// triangle without area.
struct SoaPlanes {
    std::vector<float> x, y, z, offset;
};

/// An edge of the one-sided triangles: from vertex low to high in one of them, back in the other.
struct OccluderEdge {
    std::uint32_t low, high, forward, backward;
};

/// The edges of the one-sided triangles, by clusters of 64 triangles: those within cluster c are
/// [first[c], first[c + 1]), those between clusters come last. Empty if any edge has not exactly two
/// triangles that agree.
struct OccluderEdges {
    std::vector<OccluderEdge> edges;
    std::vector<std::uint32_t> first;
    std::vector<Bounds> clusters;
};

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
    SoaPoints soa_positions;
    SoaPlanes planes;
    Vec3d planes_centre;
    OccluderEdges one_sided_edges;
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
/// cost      O(triangles in one column) a query, through a 2-D grid of triangles per axis.
class InsideTest {
public:
    /// The occluder must outlive the test.
    explicit InsideTest(const Occluder& occluder);

    bool operator()(const Vec3f& point) const;

private:
    /// Triangles by the cell of the plane across one axis that their boxes touch.
    struct Grid {
        int cells = 1;
        std::array<float, 2> lower{}, cells_per_metre{};
        std::vector<std::uint32_t> first, triangle;

        int cell(float coordinate, std::size_t k) const;
    };

    const Occluder& occluder_;
    std::array<Grid, 3> grids_;
};

}  // namespace haarfield
