#pragma once
/// The edges of an occluder, organised to find the contour from any view point.

#include <array>
#include <cstdint>
#include <vector>

#include "fields/base/vector.h"

namespace haarfield {

struct OccluderTriangles;

/// Planes of an occluder's triangles, as a structure of arrays padded to a multiple of 64. A point p is in
/// front if (x, y, z) . (p - centre) > offset. The length of the normal (x, y, z) is the triangle's smallest
/// altitude, so that the difference measures the triangle's apparent thickness from p. The offset is NaN for
/// triangles without area, missing triangles and padding: no point is in front of them or behind.
struct OccluderPlanes {
    std::vector<float> x, y, z, offset;
    Vec3d centre;  ///< [m]
};

/// Boxes as a structure of arrays, padded to whole vectors.
template <std::size_t dimensions>
struct SoaBoxes {
    std::array<std::vector<float>, dimensions> middle, half_extent;
};

/// The input of the contour rasterizer: the triangles of pieces in which most edges have two triangles, and
/// their edges in clusters. An edge with more than two triangles, or with two inconsistent ones, is stored
/// several times.
///
/// An edge belongs to the contour if the view point is on different sides of its two planes. In the dual
/// space with points (normal, offset), the planes with the view point on one side are a half-space. So a
/// cluster has no contour edges if both of its boxes are in the same half-space.
struct OccluderEdges {
    static constexpr std::size_t cluster_size = 8;

    /// An edge runs from its first end to the second along the front of its left triangle, and against its
    /// right one. For a missing triangle, the offset is NaN, its index is the number of all triangles, and
    /// its apex is any vertex. The last edges of some clusters have no triangles at all.
    struct alignas(64) Cluster {
        float planes[2][4][cluster_size];          ///< OccluderPlanes of the left and the right triangles.
        float ends[cluster_size][2][4];            ///< x, y, z, 0 of the first and the second vertices. [m]
        std::uint32_t vertices[2][cluster_size];   ///< Indices of the ends.
        std::uint32_t apices[2][cluster_size];     ///< The vertices of the triangles opposite the edges.
        std::uint32_t triangles[2][cluster_size];  ///< Left, right.
    };
    std::vector<Cluster> clusters;
    std::uint32_t one_sided_clusters = 0;  ///< The number of leading clusters with only one-sided triangles.

    // Boxes of clusters, around left and right unit normals and offsets [m] (NaN: never culled), and around
    // vertices [m].
    std::array<SoaBoxes<4>, 2> planes;
    std::vector<float> per_altitude;  ///< By cluster: 1 / the smallest altitude of its triangles. [1/m]
    SoaBoxes<3> vertices;

    /// One bit per triangle: set if its piece is left to the span rasterizer.
    std::vector<std::uint64_t> loose;
};

/// Builds the edges from an occluder's triangles and their planes.
OccluderEdges occluder_edges(const OccluderTriangles& source, const OccluderPlanes& planes);

}  // namespace haarfield
