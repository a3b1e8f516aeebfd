#pragma once
/// How light goes from surface to surface: a sparse matrix, made by rays.
///
/// The irradiance of a vertex by what its surroundings send back is
///     E = int B(w) (N.w) dw  =~  pi/K sum_k B(hit_k),
/// over K directions with the density of the cosine: what a direction meets is a row's entry, and one that
/// meets nothing, or a back, is none. Hits are snapped to a corner of their triangle, drawn by its weight, so
/// that an entry is a vertex and no more. Rows whose sum is uncertain have more directions than others.

#include "fields/base/progress.h"
#include "fields/base/result.h"
#include "shading/bounces/fine_surface.h"
#include "shading/visibility/vertex_rows.h"

namespace haarfield {

/// The matrix, and what smooths its products. Rows are those of VertexRows.
class LightTransport {
public:
    /// Shoots the rays.
    ///
    /// directions  K, of each row; a power of two, at most 4096 (asserted). Those of rows that follow each
    ///             other fill each other's gaps: see sobol_point.
    /// accuracy    the same bits for any number of threads.
    /// cost        some 0.2 us a ray, on all of oneTBB's threads; 4 bytes a hit.
    /// errors      interrupted.
    static Result<LightTransport> make(const ShadedScene& scene, const ShadingGeometry& geometry,
                                       const FineSurface& surface, int directions,
                                       const Progress& progress = {});

    /// Gives rows more directions, up to 4096, where these surfaces' light would be uncertain by more than a
    /// fiftieth of the row's radiance even when it is smoothed; the most uncertain ones if that were more
    /// than as many rays again as there are.
    ///
    /// scene, geometry, surface  as before.
    /// radiance                  by row, with what was reflected; reflectance: albedo / pi.
    /// errors                    interrupted; then the transport is of no use.
    Result<Done> refine(const ShadedScene& scene, const ShadingGeometry& geometry, const FineSurface& surface,
                        std::span<const Rgb> radiance, std::span<const Rgb> reflectance,
                        const Progress& progress = {});

    static constexpr int most_smoothing_steps = 24;  ///< As many as smooth() ever takes.

    /// Irradiance by row that diffuse surfaces of such radiance shed on each other. [W/m^2]
    ///
    /// radiance  by row.
    /// cost      some nanosecond a hit, on all of oneTBB's threads.
    std::vector<Rgb> irradiance(std::span<const Rgb> radiance) const;

    /// The same of every other row, in half of the time; the others stay as they are.
    ///
    /// first       0 or 1: of which rows.
    /// irradiance  by row.
    void update_irradiance(std::span<const Rgb> radiance, std::size_t first, std::span<Rgb> irradiance) const;

    /// Takes the mean with neighbours on the same surface, as far as a fifteenth of the distance from which
    /// the light comes (the harmonic mean over the directions): light that comes from afar changes slowly.
    ///
    /// steps  at most so many: each reaches as far as a row's nearest neighbours.
    /// cost   some ten nanoseconds a row and step.
    void smooth(std::vector<Rgb>& irradiance, int steps = most_smoothing_steps) const;

    /// Whether a row has no entries: nothing sends it light.
    bool is_empty(std::size_t row) const { return nearness_[row] == 0; }

    std::size_t bytes() const;  ///< Memory. [bytes]

private:
    static constexpr std::size_t block_rows = 64;
    /// Rows that follow each other.
    struct Block {
        std::vector<std::uint32_t> sources;           ///< Rows that are hit, of one row after the other.
        std::array<std::uint32_t, block_rows> end{};  ///< Of each row's.
    };
    /// Of an entity, whose instances share it: vertices beside each other, in the entity's order.
    struct Neighbours {
        std::vector<std::uint32_t> end;  ///< Of each place's.
        std::vector<std::uint32_t> place;
        std::vector<float> square_distance;  ///< Mean, by place. [m^2]
    };
    struct Run {
        std::size_t first, entity;  ///< Row; entity.
        float square_scale;         ///< Of the placement.
    };
    static Neighbours neighbours(const ShadedEntity& entity, std::span<const std::uint32_t> order);
    Result<Done> shoot(const ShadedScene& scene, const ShadingGeometry& geometry, const FineSurface& surface,
                       std::span<const std::uint16_t> directions, const Progress& progress);
    void find_steps();
    /// Of rows  first, first + stride, first + 2 stride  and so on.
    void gather(std::span<const Rgb> radiance, std::size_t first, std::size_t stride,
                std::span<Rgb> irradiance) const;
    std::vector<std::uint16_t> wanted_directions(std::span<const Rgb> radiance,
                                                 std::span<const Rgb> reflectance) const;

    std::vector<Block> blocks_;
    std::vector<std::uint16_t> directions_;  ///< By row.
    std::vector<float>
        nearness_;  ///< By row: mean over the directions of 1 / distance; 0: nothing is met. [1/m]
    std::vector<std::uint8_t> steps_;     ///< By row: how often it is mixed with its neighbours.
    std::vector<Neighbours> neighbours_;  ///< By entity.
    std::vector<Run> runs_;               ///< By instance.
};

}  // namespace haarfield
