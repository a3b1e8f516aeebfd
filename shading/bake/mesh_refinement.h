#pragma once
/// Meshes that are refined where their radiance requires it.

#include <limits>
#include <memory>

#include "shading/bake/discontinuity_mesh.h"
#include "shading/bake/mesh_point.h"
#include "shading/bake/radiant_mesh.h"
#include "shading/scene/vertex_loop.h"

namespace haarfield {

/// The vertex budget over the number of start vertices: most vertices are left for regions of varying
/// radiance, and nothing of the size of shadows is missed.
inline constexpr std::size_t refinement_share = 6;

/// The limits of a refinement.
struct RefinementSettings {
    /// Largest difference between the radiance at the middle of an edge and its interpolation, relative to
    /// the radiance plus the scene's mean radiance. All include the tints of the surface and are sums over
    /// the channels. The tolerance is therefore relative in bright and absolute in dark regions, for any
    /// exposure.
    float tolerance = 0.01f;
    std::size_t vertex_budget = 60000;  ///< Over all instances.
    /// True: edges that look large from the eye are split first. False: edges that are long in the world.
    bool by_view = false;
    /// True: `tolerance` is relative to the scene's mean radiance alone, as an RMSE weighs errors.
    bool is_absolute = false;
};

/// Refined meshes, and statistics of the refinement.
struct Refinement {
    std::vector<RadiantMesh> meshes;  ///< By instance.
    float largest_error = 0;          ///< Of the edges that were evaluated and not split, as `tolerance`.
    std::size_t shaded_points = 0;    ///< Vertices, and middles of edges that were not split.
    int rounds = 0;
};

/// A refinement in steps, which the caller may end at any time.
///
/// Each step shades the middles of edges that are the longest of a triangle, or whose ends differ by more
/// than the tolerance. Edges between small errors wait for a later step. It then splits edges beyond the
/// tolerance in descending order of error times length, down to half of the largest. A triangle is always
/// divided across its longest edge first, so that angles stay above half of the smallest angle in `start`.
/// There are no T-junctions. Edges below 2e-4 of the entity's radius are not split. With by_view, they are if
/// they look large, such as those of a wide ground next to the camera, down to 2e-5.
///
/// Indirect irradiance is gathered at the middles of edges whose surroundings are near, bent or unevenly
/// lit, until interpolation between the ends of larger edges there was right within the tolerance. It is
/// interpolated between the ends of the other edges.
///
/// accuracy  bit-identical for any number of threads.
/// cost      about 50 us per shaded point; two to three times as many points as vertices.
/// source    the four-triangle longest-edge partition: Rivara 1984, Algorithms for refining triangular grids
///           suitable for adaptive and multigrid techniques.
class MeshRefiner {
public:
    /// shading  must outlive the refiner.
    /// start    by instance, from mesh_radiance. Unchanged if it has more vertices than the budget.
    /// visible  by instance and vertex of `start`: 0 if no triangle of the vertex is in the picture. Edges
    ///          that are not in the picture may have errors four times as large. Empty: all are.
    MeshRefiner(const PointShading& shading, const RefinementSettings& settings,
                std::vector<RadiantMesh> start, VertexMask visible = {});
    ~MeshRefiner();

    /// Returns false if no edge was split: all errors are within the tolerance, the budget is used up, or all
    /// edges are too short.
    ///
    /// most_vertices  the step ends when the meshes have this number of vertices, or a few more.
    /// errors         interrupted; then the refiner is of no use.
    Result<bool> step(const Progress& progress = {},
                      std::size_t most_vertices = std::numeric_limits<std::size_t>::max());

    /// Replaces RefinementSettings::tolerance in the next steps. Cuts depend on the first one.
    void set_tolerance(float tolerance);

    /// A point of the mesh at the start, and its radiance. [W/(m^2 sr)]
    struct KnownPoint {
        MeshPoint at;
        Outgoing radiance;
    };
    /// Adds points. Steps divide their triangles while interpolation is wrong there, even if it is right in
    /// the middles of edges: the triangles contain something small.
    void add_known(std::span<const KnownPoint> points);

    std::size_t vertices() const;    ///< Of all instances.
    bool is_budget_used_up() const;  ///< True if the last step split fewer edges because of the budget.

    /// A point of a triangle of the current mesh.
    struct Located {
        std::uint32_t triangle = 0;              ///< Of the instance's mesh.
        std::array<std::uint32_t, 3> corners{};  ///< Its vertices.
        std::array<float, 3> weights{};
        /// Largest difference between the middle of one of the triangle's edges and its interpolation, summed
        /// over the channels. If an edge was not shaded, it is at least a quarter of the largest difference
        /// between two corners. [W/(m^2 sr)]
        float difference = 0;
    };
    /// Finds a point of an instance's mesh at the start.
    Located located(const MeshPoint& at_start) const;

    /// Returns the radiance of an instance's vertices, as sampled.
    std::span<const Outgoing> radiance(std::size_t instance) const;

    /// Returns radiance by instance and vertex, fitted to the vertices and to the shaded middles of edges
    /// (fitted_radiance).
    ///
    /// cost  some 10 us per vertex; no point is shaded.
    SceneRadiance fitted() const;

    /// Returns the current meshes, cut along discontinuities of radiance that are in the picture.
    ///
    /// most_vertices, extent  as for DiscontinuityMeshes::make.
    /// cost                   shaded points at edges whose ends differ by more than eight tolerances.
    /// errors                 interrupted.
    Result<DiscontinuityMeshes> cut(std::size_t most_vertices, CutSearch extent = CutSearch::sampled,
                                    const Progress& progress = {}) const;

    /// Returns the meshes and statistics.
    Refinement finished() &&;

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Refines meshes until the tolerance is met or the budget is used up.
///
/// start   as for MeshRefiner.
/// errors  interrupted.
Result<Refinement> refined_radiance(const PointShading& shading, const RefinementSettings& refinement,
                                    std::vector<RadiantMesh> start, const Progress& progress = {});

}  // namespace haarfield
