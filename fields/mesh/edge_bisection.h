#pragma once
/// Splitting the edges of a mesh without cracks.

#include "fields/mesh/mesh.h"

#include <array>
#include <span>
#include <vector>

namespace haarfield {

/// A mesh whose edges can be split at their middles. An edge runs between two places, not between two
/// vertices: where a seam leaves several vertices in one place, a split divides the triangles on all sides of
/// it, so that there are no T-junctions.
class EdgeBisection {
public:
    /// An edge, by the positions at its ends.
    struct Edge {
        std::array<std::uint32_t, 2> ends;     ///< Places.
        std::vector<std::uint32_t> triangles;  ///< Round it, any number.
    };

    /// The triangles of an edge that share its vertices: a seam has several sides.
    struct Side {
        std::uint32_t low, high;  ///< Vertices; low < high.
        std::vector<std::uint32_t> triangles;
    };

    explicit EdgeBisection(Mesh mesh);  ///< Takes the mesh over.

    const Mesh& mesh() const { return mesh_; }        ///< The mesh so far.
    Mesh take_mesh() && { return std::move(mesh_); }  ///< Gives it away.

    /// New edges come behind those that there are.
    std::span<const Edge> edges() const { return edges_; }
    /// Of a triangle: from corner k to k + 1.
    const std::array<std::uint32_t, 3>& edges_of(std::uint32_t triangle) const {
        return edges_of_triangle_[triangle];
    }
    double squared_length(std::uint32_t edge) const;  ///< [m^2]
    Vec3f middle(std::uint32_t edge) const;           ///< Of an edge. [m]

    /// In the order of their first triangles.
    std::vector<Side> sides(std::uint32_t edge) const;

    /// The normal of a vertex in the middle of a side: the normalised mean of its ends'.
    Vec3f middle_normal(const Side& side) const;

    /// Puts a vertex in the middle of each side, in their order, and divides the edge's triangles. The edge
    /// becomes its half at ends[0]; the other half and the cuts to the opposite corners are new. Does
    /// nothing, and returns false, where single precision has no middle.
    bool split(std::uint32_t edge);

private:
    std::uint32_t add_edge(std::uint32_t a, std::uint32_t b);

    Mesh mesh_;
    std::vector<std::uint32_t> place_of_vertex_;
    std::vector<Vec3f> places_;
    std::vector<Edge> edges_;
    std::vector<std::array<std::uint32_t, 3>> edges_of_triangle_;
};

}  // namespace haarfield
