#include "shading/transfer/view_transfer.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <memory>

#include "shading/transfer/sparse_products.h"

namespace haarfield {
namespace {

constexpr float lobe_error = 2e-3f;  ///< Relative error of truncating the lobes.

/// Fraction of the allowed error for the vectors, and for the lobes. The two errors add linearly, because
/// their coefficients are correlated where a lobe points to a small light.
constexpr float factor_share = 0.5f;

struct ViewContext {
    const ShadedScene& scene;
    const ShadingGeometry& geometry;
    const RenderSettings& settings;
    LightPyramid light;
    CoefficientSpectrum spectrum;
    double error;  ///< Relative.
};

class ViewBlockMaker {
public:
    explicit ViewBlockMaker(const ViewContext& context)
        : context_(context),
          vertex_(context.scene, context.geometry, context.settings),
          rows_(context.settings.face_size, context.spectrum, context.error) {}

    void add_row(const InstanceVertex& vertex, Rgb& diffuse) {
        if (!vertex_.look_from(vertex)) return rows_.append_empty();
        VertexBrdf& brdf = vertex_.brdf;
        if (brdf.specular == Rgb(0.0f)) {
            diffuse = vertex_.radiance(context_.light, context_.settings.depth);
            return rows_.append_empty();
        }
        // Replaces the lobe by a constant: exponent 0.
        brdf.lobes = {Lobe{.weight = 1, .exponent = 0}};
        brdf.mirror = brdf.normal;
        rows_.take(
            vertex_,
            [&](const DetailWeights* detail) { return vertex_.highlights(context_.light, diffuse, detail); },
            [&](const ProductPruning& product) { return product.energy() + double(diffuse.dot(diffuse)); });
        rows_.append();
    }
    void add_buried() { rows_.append_empty(); }
    SparseVectors complete() { return rows_.complete(); }

private:
    const ViewContext& context_;
    VertexTransfer vertex_;
    PrunedRows rows_;
};

std::vector<float> specular_exponents(const ShadedScene& scene) {
    std::vector<float> exponents;
    for (const ShadedEntity& entity : scene.entities)
        for (const Material& material : entity.materials) {
            const VertexBrdf brdf = surface_brdf<float>(material);
            for (const Lobe& lobe : brdf.lobes)
                if (brdf.has_specular() && lobe.weight > 0) exponents.push_back(lobe.mirror_exponent());
        }
    return exponents;
}

void add_lobe(const LobeVectors& vectors, float exponent, const Vec3f& direction, float weight,
              Interpolation& to) {
    const Interpolation lobe = lobe_interpolation(vectors, exponent, direction);
    for (std::size_t k = 0; k < std::size_t(lobe.count); ++k, ++to.count) {
        to.sample[std::size_t(to.count)] = lobe.sample[k];
        to.weight[std::size_t(to.count)] = lobe.weight[k] * weight;
    }
}

/// Returns the specular lobes of a vertex. Across the plane of incidence, the lobe about the half vector is
/// narrower by N.V, so it has less energy than its replacement.
Interpolation highlight_lobes(const LobeVectors& vectors, const VertexBrdf& brdf, const Vec3f& normal,
                              const Vec3f& mirror) {
    Interpolation result;
    static_assert(4 * most_lobes <= Interpolation{}.sample.size());  // lobe_interpolation returns 4 samples
    for (const Lobe& lobe : brdf.lobes)
        if (lobe.weight > 0)
            add_lobe(vectors, lobe.mirror_exponent(), mirror,
                     lobe.axis == LobeAxis::half_vector ? lobe.weight * normal.dot(mirror) : lobe.weight,
                     result);
    return result;
}

/// Lists the rows that have coefficients, and the materials.
void list_highlights(const ShadedScene& scene, const VertexRows& rows, ViewTransfer& transfer) {
    std::vector<std::size_t> first;  // By entity.
    for (const ShadedEntity& entity : scene.entities) {
        first.push_back(transfer.materials.size());
        for (const Material& material : entity.materials)
            transfer.materials.push_back(surface_brdf<float>(material));
    }
    for (std::size_t row = 0; row < rows.count(); ++row) {
        if (transfer.specular.is_empty(row)) continue;
        const auto [i, vertex] = rows[row];
        const ShadedInstance& instance = scene.instances[i];
        const Mesh& mesh = *scene.entities[instance.entity].mesh;
        transfer.highlit.push_back(
            {static_cast<std::uint32_t>(row),
             static_cast<std::uint32_t>(first[instance.entity] + mesh.vertex_materials[vertex]),
             instance.placement.point_to_world(mesh.positions[vertex]),
             instance.placement.direction_to_world(mesh.normals[vertex])});
    }
}

/// Returns the RMS of the radiance over that of the specular component, which is estimated from the spectra
/// of its factors. The specular component may err by this factor more than the total.
float total_over_specular(const ViewTransfer& transfer, const CoefficientSpectrum& vectors,
                          const CoefficientSpectrum& lobes) {
    double specular = 0, diffuse = 0;
    for (std::size_t place = 0; place < vectors.size(); ++place)
        specular += coefficients_at(place) * squared(vectors[place]) * squared(lobes[place]);
    specular *= 3 * double(transfer.diffuse.size());
    for (const Rgb& radiance : transfer.diffuse) diffuse += double(radiance.dot(radiance));
    return specular > 0 ? static_cast<float>(std::sqrt(1 + diffuse / specular)) : 1.0f;
}

}  // namespace

Result<ViewTransfer> view_transfer(const ShadedScene& scene, const ShadingGeometry& geometry,
                                   const RenderSettings& settings, const TransferSettings& transfer,
                                   const RgbCubemapTree& light, std::span<const LightSource> sources,
                                   const Progress& progress) {
    HF_TRY(const LobeShapes shapes,
           lobe_shapes(specular_exponents(scene), settings.face_size, lobe_error, progress));
    const VertexRows rows(scene, geometry);
    ViewTransfer result{
        {rows.count(), settings.face_size, 3}, std::vector<Rgb>(rows.count(), Rgb(0.0f)), {}, {}, {}, {}};
    const ViewContext context{scene,           geometry,
                              settings,        LightPyramid(light, settings.face_size),
                              shapes.spectrum, double(transfer.pruning_error * factor_share)};
    HF_TRY_DONE(make_rows(
        rows, SparseVectorBlocks::block_rows,
        [&]() -> BlockMaker {
            const auto maker = std::make_shared<ViewBlockMaker>(context);
            return {[&, maker](std::size_t row, const InstanceVertex& vertex) {
                        maker->add_row(vertex, result.diffuse[row]);
                    },
                    [maker] { maker->add_buried(); },
                    [&, maker](std::size_t block) { result.specular.blocks[block] = maker->complete(); }};
        },
        progress));
    list_highlights(scene, rows, result);
    const CoefficientSpectrum spectrum = rms_spectrum(result.specular);
    if (progress.stop.stop_requested()) return interruption();
    HF_TRY(result.lobes, lobe_vectors(shapes, spectrum,
                                      transfer.pruning_error * factor_share *
                                          total_over_specular(result, spectrum, shapes.spectrum),
                                      progress));
    HF_TRY(result.sources, source_visibility(scene, geometry, sources, result.diffuse, progress));
    return result;
}

Result<Done> shade_frame(const ViewTransfer& transfer, const ShadedScene& scene,
                         const ShadingGeometry& geometry, SceneColours& radiance, const VertexMask* vertices,
                         const Progress& progress) {
    const VertexRows rows(scene, geometry);
    const RowInterpolations highlights =
        found_interpolations(transfer.highlit.size(), progress.stop, [&](std::size_t i) {
            const auto& [row, material, position, normal] = transfer.highlit[i];
            RowInterpolation result{row, {}};
            if (vertices) {
                const auto [instance, vertex] = rows[row];
                if (!(*vertices)[instance][vertex]) return result;
            }
            result.at = highlight_lobes(transfer.lobes, transfer.materials[material], normal,
                                        mirrored_view(scene.eye, position, normal));
            return result;
        });
    std::vector<Rgb> by_row = transfer.diffuse;
    HF_TRY_DONE(add_interpolated_products(transfer.specular, transfer.lobes.lobes, highlights, by_row,
                                          progress.stop));
    HF_TRY_DONE(add_source_specular(transfer.sources, scene, geometry, by_row, vertices, progress));
    store_radiance(scene, geometry, by_row, radiance, vertices);
    return Done{};
}

}  // namespace haarfield
