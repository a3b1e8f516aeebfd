#pragma once
/// Concentrated light for radiance transfer: the vectors contain the smooth light, and shadow rays add the
/// sources.

#include "shading/bake/clustered_light.h"
#include "shading/transfer/radiance_transfer.h"

namespace haarfield {

/// The receivers of all rows, for many frames in which only the light changes.
class SourceRows {
public:
    SourceRows() = default;
    /// Lists the rows of a scene that are not buried, for its eye.
    ///
    /// errors  interrupted.
    /// cost    about 200 ns per row.
    static Result<SourceRows> make(const ShadedScene& scene, const ShadingGeometry& geometry,
                                   const Progress& progress = {});

    /// Adds the light of sources to each row's radiance.
    ///
    /// rays      of the scene for which the rows were made.
    /// quality   moving: if a cluster is visible from three or more neighbours of a vertex, or from none of
    ///           them, the same is assumed for the vertex.
    /// diffuse   by row: also receives the diffuse component; or empty.
    /// accuracy  that of add_clustered_light.
    /// errors    interrupted; the radiance is then unspecified.
    Result<Done> add(const ShadowRays& rays, std::span<const DirectionalLight> lights, FrameQuality quality,
                     std::span<Rgb> by_row, std::span<Rgb> diffuse = {}, const Progress& progress = {}) const;

    std::size_t bytes() const;  ///< Memory. [bytes]

private:
    /// Rows that are evaluated together, after the rows that they may use.
    struct Round {
        std::size_t first = 0;  ///< First place of the round; places are counted over all rounds.
        std::vector<std::uint32_t> rows;
        std::vector<ShadingPoint> receivers;
        std::vector<std::uint32_t> neighbours;  ///< By row: places in earlier rounds, three or more or none.
        std::vector<std::uint32_t> end;         ///< End of each row's neighbours.
    };
    std::vector<Round> rounds_;
};

/// Visibility of some lights around all instances except a moving one.
struct StaticSources {
    std::size_t moving = 0;                ///< The moving instance.
    std::vector<DirectionalLight> lights;  ///< Fixed.
    /// By row, one bit per light: the vertex faces it, and no other instance occludes it. Zero for rows of
    /// the moving instance.
    std::vector<std::uint64_t> lit;

    std::size_t words() const { return (lights.size() + 63) / 64; }           ///< Words of `lit` per row.
    std::size_t bytes() const { return lit.size() * sizeof(std::uint64_t); }  ///< Memory. [bytes]
};

/// Computes the visibility of lights, and adds their light without the moving instance to each row's
/// radiance.
///
/// errors  interrupted; the radiance is then unspecified.
/// cost    that of add_source_light for all rows.
Result<StaticSources> static_sources(const ShadedScene& scene, const ShadingGeometry& geometry,
                                     std::size_t moving, std::vector<DirectionalLight> lights,
                                     std::span<Rgb> by_row, const Progress& progress = {});

/// Subtracts the light that the moving instance occludes in its current place, and adds the light of the rows
/// of this instance.
///
/// scene, geometry  those of static_sources, except for the instance's placement; rays are placed in the same
///                  way.
/// accuracy         that of add_clustered_light for the instance's rows; that of rays to each light for
///                  others.
/// errors           interrupted; the radiance is then unspecified.
/// cost             nanoseconds per visible light; rays where the instance's bounding sphere may occlude it.
Result<Done> move_in_sources(const StaticSources& sources, const ShadedScene& scene,
                             const ShadingGeometry& geometry, std::span<Rgb> by_row,
                             const Progress& progress = {});

/// The visible fraction of each source at all vertices, for a moving eye: visibility is computed once.
struct SourceVisibility {
    /// The visible fraction of a source at a vertex, as one light.
    struct VisibleFraction {
        std::uint32_t row;
        DirectionalLight light;
    };
    std::vector<std::vector<VisibleFraction>>
        blocks;  ///< By 64 rows; rows with specular reflection, in their order.

    std::size_t bytes() const;  ///< Memory. [bytes]
};

/// Computes the visibility of sources, and adds their diffuse reflection to `diffuse`, by row.
///
/// errors  interrupted.
Result<SourceVisibility> source_visibility(const ShadedScene& scene, const ShadingGeometry& geometry,
                                           std::span<const LightSource> sources, std::span<Rgb> diffuse,
                                           const Progress& progress = {});

/// Adds the specular reflection of the visible sources, towards the scene's eye.
///
/// accuracy  exact except that the visible fraction of each source counts as one direction: lobes that are
///           not much wider than a source appear slightly too sharp.
/// cost      about 50 ns per visible source of a row.
Result<Done> add_source_specular(const SourceVisibility& visibility, const ShadedScene& scene,
                                 const ShadingGeometry& geometry, std::span<Rgb> by_row,
                                 const VertexMask* wanted = nullptr, const Progress& progress = {});

}  // namespace haarfield
