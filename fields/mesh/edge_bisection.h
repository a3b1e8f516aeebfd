#pragma once
/// Splitting of edges without cracks.

#include "fields/mesh/mesh.h"

#include <array>
#include <span>
#include <vector>

namespace haarfield {

/// A mesh whose edges can be split at their midpoints. An edge connects two places, not two vertices. If
/// several vertices share a place along a seam, a split divides the triangles on all sides of the seam, so
/// that there are no T-junctions.
class EdgeBisection {
public:
    /// An edge between two places.
    struct Edge {
        std::array<std::uint32_t, 2> ends;     ///< Indices of places.
        std::vector<std::uint32_t> triangles;  ///< All triangles at the edge, in any number.
    };

    /// The triangles of an edge that share its vertices. A seam has several sides.
    struct Side {
        std::uint32_t low, high;  ///< Vertices; low < high.
        std::vector<std::uint32_t> triangles;
    };

    /// A point of a triangle, as weights of the triangle's corners.
    struct TrianglePoint {
        std::uint32_t triangle = 0;
        std::array<double, 3> weights{};
    };

    explicit EdgeBisection(Mesh mesh);  ///< Takes ownership of the mesh.

    const Mesh& mesh() const { return mesh_; }        ///< The current mesh.
    Mesh take_mesh() && { return std::move(mesh_); }  ///< Moves the mesh out.

    /// New edges are appended.
    std::span<const Edge> edges() const { return edges_; }
    /// The edges of a triangle, from corner k to k + 1.
    const std::array<std::uint32_t, 3>& edges_of(std::uint32_t triangle) const {
        return edges_of_triangle_[triangle];
    }
    double squared_length(std::uint32_t edge) const;  ///< [m^2]
    Vec3f middle(std::uint32_t edge) const;           ///< Midpoint of an edge. [m]

    /// Returns the sides of an edge, in the order of their first triangles.
    std::vector<Side> sides(std::uint32_t edge) const;

    /// Adds a vertex at the midpoint of each side, in their order, and divides the edge's triangles. The edge
    /// becomes its half at ends[0]. The other half and the edges to the opposite corners are new. Does
    /// nothing and returns false if single precision has no value in between.
    bool split(std::uint32_t edge);

    /// Returns the triangle that now contains a point of a triangle of the mesh at the start.
    ///
    /// cost  proportional to the number of splits of the triangles around the point.
    TrianglePoint located(TrianglePoint point) const;

private:
    /// A split of a triangle: it keeps corner `corner`, and `other` gets the next corner.
    struct Cut {
        std::uint8_t corner;
        std::uint32_t other;
    };

    std::uint32_t add_edge(std::uint32_t a, std::uint32_t b);

    Mesh mesh_;
    std::vector<std::uint32_t> place_of_vertex_;
    std::vector<Vec3f> places_;
    std::vector<Edge> edges_;
    std::vector<std::array<std::uint32_t, 3>> edges_of_triangle_;
    std::vector<std::vector<Cut>> cuts_;  ///< By triangle, in the order of time.
};

/// Returns the normalised interpolation of the normals at the ends of a side.
///
/// share  0 at `low`, 1 at `high`.
Vec3f interpolated_normal(const Mesh& mesh, const EdgeBisection::Side& side, double share);

/// Appends a vertex on a side, whose position and other values are interpolated. Returns its index.
///
/// share  as above.
std::uint32_t add_interpolated_vertex(Mesh& mesh, const EdgeBisection::Side& side, double share);

}  // namespace haarfield
