#pragma once
/// The edges of an occluder, so that those of its contour are found from any view point.

#include <array>
#include <cstdint>
#include <vector>

#include "fields/base/vector.h"

namespace haarfield {

struct OccluderTriangles;

/// Planes of an occluder's triangles by coordinate, padded to multiples of 64. A point p is in front where
/// (x, y, z) . (p - centre) > offset;  (x, y, z) is the normal, as long as the triangle's least altitude:
/// what is compared is a measure of how thick the triangle looks from p. A triangle without area, one that is
/// not there and the padding have NaN as offset, so that nothing is in front of them or behind.
struct OccluderPlanes {
    std::vector<float> x, y, z, offset;
    Vec3d centre;  ///< [m]
};

/// Boxes by coordinate, padded to whole vectors.
template <std::size_t dimensions>
struct SoaBoxes {
    std::array<std::vector<float>, dimensions> middle, half_extent;
};

/// What the contour rasterizer works with: the triangles of those pieces whose edges have two triangles for
/// the most part, and their edges, in clusters. An edge with more triangles, or with two that do not agree,
/// is there more than once.
///
/// An edge belongs to the contour if its two planes have the view point on different sides. Planes that have
/// it on one side are a half-space of the dual space, whose points are (normal, offset). So clusters both of
/// whose boxes lie on one side have no contour edges.
struct OccluderEdges {
    static constexpr std::size_t cluster_size = 8;

    /// An edge runs from its first end to the second on the front of its left triangle, and against the right
    /// one's. Where there is no triangle, NaN is its offset, the number of all triangles stands in its place,
    /// and any vertex for its apex. The last edges of some clusters have none at all.
    struct alignas(64) Cluster {
        float planes[2][4][cluster_size];  ///< Of the left triangles and the right ones: OccluderPlanes.
        float ends[cluster_size][2][4];    ///< x, y, z, 0 of the first vertices and the second. [m]
        std::uint32_t vertices[2][cluster_size];   ///< Their numbers.
        std::uint32_t apices[2][cluster_size];     ///< The vertices of the triangles off the edges.
        std::uint32_t triangles[2][cluster_size];  ///< Left, right.
    };
    std::vector<Cluster> clusters;
    std::uint32_t one_sided_clusters = 0;  ///< So many have one-sided triangles alone, on both sides.

    // Boxes by cluster, around unit normals and offsets [m] left and right (NaN: always to be looked at), and
    // around vertices [m].
    std::array<SoaBoxes<4>, 2> planes;
    std::vector<float> per_altitude;  ///< By cluster: 1 / the least altitude of its triangles. [1/m]
    SoaBoxes<3> vertices;

    std::vector<std::uint64_t> loose;  ///< Bit per triangle: set if its piece is left to the span rasterizer.
};

/// From an occluder's triangles and their planes.
OccluderEdges occluder_edges(const OccluderTriangles& source, const OccluderPlanes& planes);

}  // namespace haarfield
