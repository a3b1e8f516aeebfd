#pragma once
/// Radiance transfer for variable light: rotated, dimmed, exchanged, mixed.

#include "shading/transfer/grouped_columns.h"
#include "shading/transfer/source_rows.h"

namespace haarfield {

/// T = BRDF x visibilities x cosine per vertex, without the materials' colours. [1/sr]
struct LightTransfer {
    /// Largest number of terms of a BRDF: diffuse, specular, and for metals specular times F
    /// (transfer_terms).
    static constexpr std::size_t most_terms = 3;
    using Colours = std::array<Rgb, most_terms>;  ///< Factors of the terms. [1/sr]

    /// Blocks of groups. Each eight rows have one group per term: group  terms * k + t  of a block is term t
    /// of its k-th eight rows.
    std::vector<GroupedColumns> blocks;
    std::size_t terms = 2;                     ///< 3 if the scene has metals.
    std::vector<Colours> colours;              ///< By material of the scene.
    std::vector<std::uint32_t> colour_of_row;  ///< Index in `colours`.
    CoefficientSpectrum spectrum{};            ///< Of T, over a sample of the rows and all channels.
    float pruning_error = 0;                   ///< The error of the pruning of the vectors.
    SourceRows sources;                        ///< For concentrated light.

    /// Returns the number of rows of each block except the last.
    std::size_t block_rows() const { return GroupedColumns::most_groups / terms * group_rows; }
    std::size_t bytes() const;  ///< Memory. [bytes]
};

/// Computes the transfer vectors.
///
/// typical  a light similar to those to come; determines the coefficients that are kept. Light with more
///          detail is reproduced less exactly.
/// errors   interrupted.
/// cost     a function product per vertex.
Result<LightTransfer> light_transfer(const ShadedScene& scene, const ShadingGeometry& geometry,
                                     const RenderSettings& settings, const TransferSettings& transfer,
                                     const DenseCoefficients& typical, const Progress& progress = {});

/// Computes the radiance of each row under a light (lighting.h: with the solid angle), towards the eye of the
/// vectors.
///
/// The least important coefficients of the light are dropped, with an eighth of the pruning error.
///
/// rays             of the scene for which the vectors were computed.
/// lights, quality  of the sources that `light` does not contain: see SourceRows.
/// radiance         overwritten, for store_radiance.
/// diffuse          null, or overwritten with the diffuse component. >= 0
/// accuracy         in addition to pruning: rounding to bytes, 0.2 %; the constant cosine over cells
///                  (transfer_terms), at most 0.1 % unless `light` contains suns.
/// errors           interrupted; the rows are then unspecified.
/// cost             a multiplication and an addition for each coefficient that a vertex and the light share.
Result<Done> shade_rows(const LightTransfer& transfer, const ShadowRays& rays, const DenseCoefficients& light,
                        std::span<const DirectionalLight> lights, FrameQuality quality,
                        std::vector<Rgb>& radiance, std::vector<Rgb>* diffuse = nullptr,
                        const Progress& progress = {});

/// Computes the radiance by vertex.
///
/// scene, geometry  those of the vectors.
/// errors           interrupted; `radiance` is then unchanged.
Result<Done> shade_frame(const LightTransfer& transfer, const ShadedScene& scene,
                         const ShadingGeometry& geometry, const DenseCoefficients& light,
                         std::span<const DirectionalLight> lights, FrameQuality quality,
                         SceneColours& radiance, const Progress& progress = {});

}  // namespace haarfield
