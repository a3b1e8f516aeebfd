#pragma once
/// The transport of diffuse light between surfaces, as a sparse matrix that is computed with rays.
///
/// The indirect irradiance of a vertex with normal N is
///     E = int B(w) (N.w) dw  =~  pi/K sum_k B(hit_k),
/// where B is the diffuse radiance of the surface in direction w. The K directions have the density of the
/// cosine. Each ray that hits the front of a surface is an entry in the row of the vertex. An entry is only
/// the index of a vertex: a corner of the hit triangle, chosen at random with its barycentric weight. Rows
/// whose sum is uncertain have more directions.
///
/// Hidden rows are those of buried vertices and of vertices inside other instances. They have no entries, and
/// rays that hit their triangles choose among the other corners.

#include "fields/base/progress.h"
#include "fields/base/result.h"
#include "shading/bounces/coarse_transport.h"
#include "shading/bounces/fine_surface.h"
#include "shading/visibility/vertex_rows.h"

namespace haarfield {

/// The matrix, and the smoothing of irradiance over surfaces. Rows are those of VertexRows.
class LightTransport {
public:
    /// Traces the rays of all rows.
    ///
    /// directions  K, the number per row; a power of two, at most 4096 (asserted). The directions of
    ///             consecutive rows fill each other's gaps; see sobol_point.
    /// accuracy    bit-identical for any number of threads.
    /// cost        about 0.2 us per ray, on all of oneTBB's threads; 4 bytes per hit.
    /// errors      interrupted.
    static Result<LightTransport> make(const ShadedScene& scene, const ShadingGeometry& geometry,
                                       const FineSurface& surface, int directions,
                                       const Progress& progress = {});

    /// Adds directions, up to 4096, to rows whose indirect radiance has a standard error of more than 2 % of
    /// the row's radiance after smoothing. If this requires more rays than the matrix has so far, the number
    /// of directions is reduced everywhere, so that only the most uncertain rows get more.
    ///
    /// scene, geometry, surface  those of make().
    /// radiance                  diffuse radiance by row, direct and indirect. [W/(m^2 sr)]
    /// reflectance               diffuse albedo / pi, by row. [1/sr]
    /// errors                    interrupted; the transport must then be discarded.
    Result<Done> refine(const ShadedScene& scene, const ShadingGeometry& geometry, const FineSurface& surface,
                        std::span<const Rgb> radiance, std::span<const Rgb> reflectance,
                        const Progress& progress = {});

    static constexpr int most_smoothing_steps = 24;  ///< Maximum number of steps of smooth().

    /// Returns the irradiance of all rows by the diffuse radiance of all rows. [W/m^2]
    ///
    /// radiance  by row. [W/(m^2 sr)]
    /// cost      about 1 ns per hit, on all of oneTBB's threads.
    std::vector<Rgb> irradiance(std::span<const Rgb> radiance) const;

    /// Updates the irradiance of every other row, in half the time of irradiance().
    ///
    /// first       0 for the even rows, 1 for the odd rows.
    /// irradiance  by row. [W/m^2]
    void update_irradiance(std::span<const Rgb> radiance, std::size_t first, std::span<Rgb> irradiance) const;

    /// Averages irradiance over neighbouring vertices of the same surface. The radius is about a fifteenth of
    /// the distance to the hit surfaces (harmonic mean over the directions), because distant light varies
    /// slowly over a surface.
    ///
    /// steps  maximum number of steps. A step averages each row with its nearest neighbours that are not
    ///        hidden.
    /// cost   about 10 ns per row and step.
    void smooth(std::vector<Rgb>& irradiance, int steps = most_smoothing_steps) const;

    /// Returns the transport between groups of neighbouring rows. Groups are narrow compared with the
    /// distance to the hit surfaces, and do not cross edges.
    CoarseTransport coarse() const;

    /// True if no ray of the row hits a surface, so that the row receives no indirect light. True for hidden
    /// rows.
    bool is_empty(std::size_t row) const { return nearness_[row] == 0; }

    std::span<const std::uint8_t> hidden() const { return hidden_; }  ///< That of hidden_rows.
    std::size_t bytes() const;  ///< Returns the memory that the matrix occupies. [bytes]

private:
    static constexpr std::size_t block_rows = 64;
    /// The entries of consecutive rows.
    struct Block {
        std::vector<std::uint32_t> sources;           ///< Hit rows, ordered by the row that they light.
        std::array<std::uint32_t, block_rows> end{};  ///< End of each row's entries in `sources`.

        /// Returns the entries of the block's k-th row.
        std::span<const std::uint32_t> of(std::size_t k) const {
            const std::size_t first = k > 0 ? end[k - 1] : 0;
            return std::span(sources).subspan(first, end[k] - first);
        }
    };
    /// The neighbours of an entity's vertices, which all its instances share. A place is an index into the
    /// entity's ShadingGeometry::Entity::order.
    struct Neighbours {
        std::vector<std::uint32_t> end;      ///< End of each vertex's neighbours in `place`, by place.
        std::vector<std::uint32_t> place;    ///< Places of the neighbours.
        std::vector<float> square_distance;  ///< Mean squared distance to the neighbours, by place. [m^2]

        /// Returns the places of a vertex's neighbours.
        std::span<const std::uint32_t> of(std::size_t vertex) const {
            const std::size_t first = vertex > 0 ? end[vertex - 1] : 0;
            return std::span(place).subspan(first, end[vertex] - first);
        }
    };
    /// The rows of one instance.
    struct Run {
        std::size_t first, entity;  ///< First row; index of the entity.
        float square_scale;         ///< Squared scale of the placement.
    };
    static Neighbours neighbours(const ShadedEntity& entity, std::span<const std::uint32_t> order);
    /// Chooses the groups of coarse(): sets CoarseTransport::group, and returns their sizes.
    std::vector<std::uint32_t> find_groups(std::vector<std::uint32_t>& group) const;
    Result<Done> shoot(const ShadedScene& scene, const ShadingGeometry& geometry, const FineSurface& surface,
                       std::span<const std::uint16_t> directions, const Progress& progress);
    void find_steps();
    /// Computes the irradiance of the rows first, first + stride, first + 2 stride ...
    void gather(std::span<const Rgb> radiance, std::size_t first, std::size_t stride,
                std::span<Rgb> irradiance) const;
    std::vector<std::uint16_t> wanted_directions(std::span<const Rgb> radiance,
                                                 std::span<const Rgb> reflectance) const;

    std::vector<Block> blocks_;
    std::vector<std::uint16_t> directions_;  ///< Number of directions, by row.
    std::vector<float>
        nearness_;  ///< By row: mean of 1 / distance over the directions; 0 for those without hit. [1/m]
    std::vector<std::uint8_t> steps_;     ///< Number of smoothing steps, by row.
    std::vector<std::uint8_t> hidden_;    ///< By row: 1 if it is hidden.
    std::vector<Neighbours> neighbours_;  ///< By entity.
    std::vector<Run> runs_;               ///< By instance.
};

}  // namespace haarfield
