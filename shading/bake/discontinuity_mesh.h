#pragma once
/// Meshes whose triangles are cut along the edges of hard shadows.

#include <span>

#include "fields/mesh/edge_bisection.h"
#include "shading/bake/radiant_mesh.h"
#include "shading/visibility/placed_solids.h"

namespace haarfield {

/// The edges among which discontinuities are searched.
enum class CutSearch {
    sampled,  ///< All, if a sample has many discontinuities; else none.
    all,
};

/// A mesh to be cut, with the radiance of its vertices. Its pointers must outlive the call.
struct UncutMesh {
    const EdgeBisection* bisection = nullptr;
    std::span<const Outgoing> radiance;                ///< By vertex. [W/(m^2 sr)]
    const LocalSamples* samples = nullptr;             ///< Of the vertices.
    std::span<const GatheredIrradiance> irradiance{};  ///< By vertex.
    std::span<const Rgb> tints{};                      ///< By vertex; empty: all are 1.
    std::vector<bool> candidates;                      ///< By edge: true if it may be cut.
};

/// Meshes that are cut along discontinuities of their radiance.
class DiscontinuityMeshes {
public:
    /// Cuts meshes, one per instance.
    ///
    /// Along each candidate edge whose ends differ enough, bisection finds the interval that contains most of
    /// the difference. If it is short, its ends become vertices with the radiance there. Each triangle with
    /// such edges is divided along them, so that a narrow strip separates light and shadow. Edges on seams,
    /// where vertices have the same place, are not cut. There are no T-junctions.
    ///
    /// contrast       smallest difference between the ends of an edge, with tints, summed over the channels.
    /// most_vertices  of all meshes; the edges with the largest difference times length are cut first.
    /// extent         whether a sample of the edges decides if the others are searched.
    /// accuracy       bit-identical for any number of threads.
    /// cost           up to seven shaded points per candidate with that contrast.
    /// errors         interrupted.
    /// source         Lischinski, Tampieri and Greenberg 1992, Discontinuity meshing for accurate radiosity;
    ///                here the discontinuities are found on edges instead of computed from occluders.
    static Result<DiscontinuityMeshes> make(const PointShading& shading, std::span<const UncutMesh> meshes,
                                            const PlacedSolids& solids, float contrast,
                                            std::size_t most_vertices, CutSearch extent,
                                            const Progress& progress = {});

    /// A point of a triangle, as weights of its corners.
    struct Located {
        std::array<std::uint32_t, 3> corners{};  ///< Vertices.
        std::array<float, 3> weights{};
    };
    /// Finds a point of a triangle of an uncut mesh.
    Located located(std::size_t instance, std::uint32_t triangle, const std::array<float, 3>& weights) const;

    const std::vector<RadiantMesh>& meshes() const { return meshes_; }        ///< By instance.
    std::vector<RadiantMesh> take_meshes() && { return std::move(meshes_); }  ///< Moves them out.
    std::size_t cut_edges() const { return cut_edges_; }                      ///< Of all meshes.
    std::size_t added_vertices() const { return added_vertices_; }            ///< By the cuts.

    /// A part of a divided triangle.
    struct Part {
        std::array<std::uint32_t, 3> vertices{};
        std::array<std::array<float, 3>, 3> corners{};  ///< Of the part, as weights of the divided triangle.
    };

private:
    std::vector<RadiantMesh> meshes_;
    /// By instance and triangle: index in parts_; the largest value for undivided triangles.
    std::vector<std::vector<std::uint32_t>> parts_of_;
    std::vector<std::vector<std::vector<Part>>> parts_;  ///< By instance, for each divided triangle.
    std::size_t cut_edges_ = 0, added_vertices_ = 0;
};

}  // namespace haarfield
