#pragma once
/// Indirect light in specular reflections for a fixed eye: the rays of the lobes are traced once.

#include "fields/base/progress.h"
#include "fields/base/result.h"
#include "shading/bounces/fine_surface.h"
#include "shading/visibility/vertex_rows.h"

namespace haarfield {

/// The surface points that the rays of the vertices' specular lobes hit. The rays are those of
/// IndirectLight::outgoing. Each frame multiplies the hits by its diffuse radiance. Rows are those of
/// VertexRows.
class SpecularHits {
public:
    /// Traces the rays towards the scene's eye.
    ///
    /// surface  placed like the scene.
    /// hidden   that of hidden_rows.
    /// wanted   vertices with reflections; null: all.
    /// cost     about 5 us per specular vertex and lobe, on all of oneTBB's threads; 20 bytes per hit, at
    ///          most 24 hits per lobe.
    /// errors   interrupted.
    static Result<SpecularHits> make(const ShadedScene& scene, const ShadingGeometry& geometry,
                                     const FineSurface& surface, std::span<const std::uint8_t> hidden,
                                     const VertexMask* wanted = nullptr, const Progress& progress = {});

    /// True if no ray has hit a surface.
    bool is_empty() const { return blocks_.empty(); }

    /// Computes the specular reflection of diffuse radiance, for every `stride`-th row that has hits, from
    /// the row with number `first` among these. Other values remain.
    ///
    /// radiance   diffuse outgoing radiance, by row. [W/(m^2 sr)]
    /// reflected  by row. [W/(m^2 sr)]
    /// accuracy   that of IndirectLight::outgoing. Hidden corners of triangles (hidden_rows) do not
    ///            contribute; the weights of the others are scaled.
    /// cost       about 10 ns per hit, on all of oneTBB's threads.
    void reflect(std::span<const Rgb> radiance, std::span<Rgb> reflected, std::size_t first = 0,
                 std::size_t stride = 1) const;

    std::size_t bytes() const;  ///< Memory. [bytes]

private:
    static constexpr std::size_t block_rows = 64;
    /// A hit: three corners of a triangle and their weights.
    struct Hit {
        std::array<std::uint32_t, 3> rows;      ///< Of the corners.
        std::array<std::uint16_t, 2> fraction;  ///< Weights of the second and third corner, times 65,535.
        float weight;                           ///< LobeRay::weight.
    };
    struct Row {
        std::uint32_t row;
        std::uint32_t end;       ///< Of the row's hits in the block.
        std::uint32_t material;  ///< Index in materials_.
    };
    /// Consecutive rows that have hits.
    struct Block {
        std::vector<Row> rows;
        std::vector<Hit> hits;
        std::vector<float> metallic;  ///< By hit: 1 - F of metals; empty if the scene has none.
    };
    struct Reflectance {
        Rgb specular, metallic;  ///< See VertexBrdf.
    };

    std::vector<Block> blocks_;
    std::vector<Reflectance> materials_;
};

}  // namespace haarfield
