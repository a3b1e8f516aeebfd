#pragma once
/// Radiance transfer for a light that changes: turned, dimmed, exchanged, mixed.

#include "shading/transfer/concentrated_light.h"
#include "shading/transfer/source_rows.h"

namespace haarfield {

/// x, y and z of a group's rows, side by side.
using GroupNormals = std::array<std::array<float, group_rows>, 3>;

/// T = BRDF x visibilities x cosine per vertex, without the materials' colours. [1/sr]
struct LightTransfer {
    /// The most terms of a BRDF: diffuse, highlights, and of metals highlights times F (transfer_terms).
    static constexpr std::size_t most_terms = 3;
    using Colours = std::array<Rgb, most_terms>;  ///< What each term is multiplied with. [1/sr]

    /// Groups of neighbouring rows, and of each group one for each term: group  terms * k + t  of a block is
    /// term t of its k-th eight rows.
    std::vector<GroupedColumns> blocks;
    std::size_t terms = 2;                     ///< 3 if there are metals in the scene.
    std::vector<Colours> colours;              ///< Of the scene's materials.
    std::vector<std::uint32_t> colour_of_row;  ///< In `colours`.
    std::vector<GroupNormals> normals;         ///< By group_rows rows.
    DenseCoefficients directions;              ///< direction_coefficients.
    CoefficientSpectrum spectrum{};            ///< Of T, over some rows and the channels.
    float pruning_error = 0;                   ///< That the vectors were made with.
    SourceRows sources;                        ///< For light that is concentrated.

    /// Of each block but the last.
    std::size_t block_rows() const { return GroupedColumns::most_groups / terms * group_rows; }
    std::size_t bytes() const;  ///< Memory. [bytes]
};

/// typical  a light like those that are to come: it tells which coefficients matter. One with more detail
///          is reproduced less exactly.
/// errors   interrupted.
/// cost     a function product per vertex.
Result<LightTransfer> light_transfer(const ShadedScene& scene, const ShadingGeometry& geometry,
                                     const RenderSettings& settings, const TransferSettings& transfer,
                                     const DenseCoefficients& typical, const Progress& progress = {});

/// Radiance of each row under a light (lighting.h: with the solid angle) towards the eye that the vectors
/// were made for.
///
/// Those of the light's coefficients that matter least are left out, to an eighth of the error of pruning.
///
/// The vectors hold the cosine constant over cells; what that costs where light is concentrated is made good:
/// concentrated_light.h.
///
/// rays             of the scene as it was when the vectors were made.
/// lights, quality  of what is concentrated and not in `light`: see SourceRows.
/// radiance         becomes known, for store_radiance.
/// diffuse          null: not wanted; else the diffuse part becomes known. >= 0
/// accuracy         besides pruning, rounding to bytes: 0.2 %.
/// errors           interrupted; then the rows are of no use.
/// cost             a multiplication and an addition for each coefficient that a vertex and the light have in
///                  common, and for some twenty more a concentrated source.
Result<Done> shade_rows(const LightTransfer& transfer, const ShadowRays& rays, const DenseCoefficients& light,
                        std::span<const DirectionalLight> lights, FrameQuality quality,
                        std::vector<Rgb>& radiance, std::vector<Rgb>* diffuse = nullptr,
                        const Progress& progress = {});

/// The same, vertex by vertex.
///
/// scene, geometry  those that the vectors were made for.
/// errors           interrupted; then `radiance` is as it was.
Result<Done> shade_frame(const LightTransfer& transfer, const ShadedScene& scene,
                         const ShadingGeometry& geometry, const DenseCoefficients& light,
                         std::span<const DirectionalLight> lights, FrameQuality quality,
                         SceneColours& radiance, const Progress& progress = {});

}  // namespace haarfield
