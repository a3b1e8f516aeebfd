#pragma once
/// Concentrated light beside radiance transfer: what vectors give is smooth, and shadow rays add the rest.

#include "shading/transfer/light_clusters.h"
#include "shading/transfer/radiance_transfer.h"

namespace haarfield {

/// Rows with what light finds there, for many frames in which light alone changes.
class SourceRows {
public:
    SourceRows() = default;
    /// Those of a scene that are not buried, for its eye.
    ///
    /// errors  interrupted.
    /// cost    some 200 ns a row.
    static Result<SourceRows> make(const ShadedScene& scene, const ShadingGeometry& geometry,
                                   const Progress& progress = {});

    /// Adds to each row's radiance what the lights shed on its vertex.
    ///
    /// rays      of the scene as it was.
    /// quality   moving: a vertex is taken to see of a cluster what all of three neighbours or more see, or
    ///           none of them does.
    /// diffuse   by row, to which the diffuse part is added, too; or none.
    /// accuracy  that of add_clustered_light.
    /// errors    interrupted; then the radiance is of no use.
    Result<Done> add(const ShadowRays& rays, std::span<const DirectionalLight> lights, FrameQuality quality,
                     std::span<Rgb> by_row, std::span<Rgb> diffuse = {}, const Progress& progress = {}) const;

    std::size_t bytes() const;  ///< Memory. [bytes]

private:
    /// Rows that are asked together, after those that they may take from.
    struct Round {
        std::size_t first = 0;  ///< Its first place; they are counted over all rounds.
        std::vector<std::uint32_t> rows;
        std::vector<SourceReceiver> receivers;
        std::vector<std::uint32_t> neighbours;  ///< Of each row: places of earlier rounds; three or more,
        std::vector<std::uint32_t> end;         ///< or none; and where each row's end.
    };
    std::vector<Round> rounds_;
};

/// What of some lights is seen past all instances but one that moves.
struct StandingSources {
    std::size_t moving = 0;                ///< The instance.
    std::vector<DirectionalLight> lights;  ///< That stay as they are.
    /// By row, a bit for each light: the vertex faces it, and nothing else is in between. Rows of the moving
    /// instance have none.
    std::vector<std::uint64_t> lit;

    std::size_t words() const { return (lights.size() + 63) / 64; }           ///< A row's, of `lit`.
    std::size_t bytes() const { return lit.size() * sizeof(std::uint64_t); }  ///< Memory. [bytes]
};

/// Finds them, and adds to each row's radiance what they shed if the instance is not there.
///
/// errors  interrupted; then the radiance is of no use.
/// cost    that of add_source_light for all rows.
Result<StandingSources> standing_sources(const ShadedScene& scene, const ShadingGeometry& geometry,
                                         std::size_t moving, std::vector<DirectionalLight> lights,
                                         std::span<Rgb> by_row, const Progress& progress = {});

/// Takes from each row's radiance what the moving instance blocks where it is now, and adds to its own rows
/// what they see.
///
/// scene, geometry  as they were, but for the instance's placement; rays are placed alike.
/// accuracy         its own rows: that of add_clustered_light; all others: that of rays to each light.
/// errors           interrupted; then the radiance is of no use.
/// cost             nanoseconds a light that is lit; rays where the instance's bounding sphere may block it.
Result<Done> move_in_sources(const StandingSources& sources, const ShadedScene& scene,
                             const ShadingGeometry& geometry, std::span<Rgb> by_row,
                             const Progress& progress = {});

/// What vertices see of each source, for an eye that moves: visibility is found once.
struct SourceSights {
    /// The part of a source that a vertex sees, as one light.
    struct Sight {
        std::uint32_t row;
        DirectionalLight light;
    };
    std::vector<std::vector<Sight>> blocks;  ///< By 64 rows; of rows that have highlights, in their order.

    std::size_t bytes() const;  ///< Memory. [bytes]
};

/// Finds the sights, and adds to `diffuse`, by row, what the lights shed by the diffuse terms.
///
/// errors  interrupted.
Result<SourceSights> source_sights(const ShadedScene& scene, const ShadingGeometry& geometry,
                                   std::span<const LightSource> sources, std::span<Rgb> diffuse,
                                   const Progress& progress = {});

/// Adds the highlights of what is seen of the sources, towards the scene's eye.
///
/// accuracy  exact but for taking the seen part of each source as one direction: lobes that are not much
///           wider than a source are somewhat sharper than they should be.
/// cost      some 50 ns a sight.
Result<Done> add_source_highlights(const SourceSights& sights, const ShadedScene& scene,
                                   const ShadingGeometry& geometry, std::span<Rgb> by_row,
                                   const VertexMask* wanted = nullptr, const Progress& progress = {});

}  // namespace haarfield
