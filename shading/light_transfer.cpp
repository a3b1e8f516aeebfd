#include "shading/light_transfer.h"

#include <tbb/parallel_for.h>

#include <memory>

#include "shading/product_pruning.h"

namespace haarfield {
namespace {

double squared(float value) {
    return double(value) * value;
}
double energy(const Rgb& c) {
    return squared(c.x) + squared(c.y) + squared(c.z);
}

struct Frame {
    const ShadedScene& scene;
    const ShadingGeometry& geometry;
    const RenderSettings& settings;
    LightPyramid white;
    CoefficientSpectrum spectrum;
    double allowed;  ///< Energy, relative.
};

/// Makes the two rows of a vertex.
class LightRowMaker {
public:
    explicit LightRowMaker(const Frame& frame)
        : frame_(frame),
          vertex_(frame.scene, frame.geometry, frame.settings),
          pruning_(frame.settings.face_size, frame.spectrum) {}

    void operator()(std::size_t instance, std::uint32_t vertex, std::span<SparseVectors* const> to) {
        std::array<double, 2> weights{};
        if (vertex_.look_from(instance, vertex)) {
            weights = {energy(vertex_.brdf.diffuse), energy(vertex_.brdf.specular)};
            // Under white light, the two terms in a channel each.
            vertex_.brdf.diffuse = weights[0] > 0 ? Rgb(1, 0, 0) : Rgb(0.0f);
            vertex_.brdf.specular = weights[1] > 0 ? Rgb(0, 1, 0) : Rgb(0.0f);
            pruning_.take(vertex_.product(frame_.white));
        }
        // Half of the error for each of the two.
        const double allowed = 0.5 * frame_.allowed *
                               (weights[0] * pruning_.energies()[0] + weights[1] * pruning_.energies()[1]);
        for (std::size_t term = 0; term < 2; ++term)
            if (weights[term] > 0)
                pruning_.append_channel(term, allowed / weights[term], *to[term]);
            else
                to[term]->append_empty();
    }

private:
    const Frame& frame_;
    VertexTransfer vertex_;
    ProductPruning pruning_;
};

RgbCubemapTree white_light() {
    RgbCubemapTree white;
    for (RgbQuadtree& face : white.faces) face.scaling = Rgb(1.0f);
    return white;
}

}  // namespace

Result<LightTransfer> light_transfer(const ShadedScene& scene, const ShadingGeometry& geometry,
                                     const RenderSettings& settings, const TransferSettings& transfer,
                                     const DenseCoefficients& typical, const Progress& progress) {
    const std::size_t rows = TransferRows(scene).count();
    LightTransfer result{{rows, settings.face_size, 1}, {rows, settings.face_size, 1}};
    const Frame frame{scene,
                      geometry,
                      settings,
                      LightPyramid(white_light(), settings.face_size),
                      rms_spectrum(typical),
                      squared(transfer.pruning_error)};
    SparseVectorBlocks* const sets[] = {&result.diffuse, &result.specular};
    const Result<Done> filled = fill_rows(
        scene, sets,
        [&frame]() -> RowMaker {
            return [maker = std::make_shared<LightRowMaker>(frame)](
                       std::size_t, std::size_t instance, std::uint32_t vertex,
                       std::span<SparseVectors* const> to) { (*maker)(instance, vertex, to); };
        },
        progress);
    if (!filled) return filled.error();
    return result;
}

void transfer_light(const LightTransfer& transfer, const ShadedScene& scene, const DenseCoefficients& light,
                    VertexRadiance& radiance) {
    const TransferRows rows(scene);
    std::vector<Rgb> by_row(rows.count());
    constexpr std::size_t block_rows = SparseVectorBlocks::block_rows;
    tbb::parallel_for(std::size_t(0), transfer.diffuse.blocks.size(), [&](std::size_t b) {
        std::array<Rgb, block_rows> diffuse, specular;
        const std::size_t count = transfer.diffuse.blocks[b].rows();
        inner_products(transfer.diffuse.blocks[b], light, std::span(diffuse).first(count));
        inner_products(transfer.specular.blocks[b], light, std::span(specular).first(count));
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t row = b * block_rows + i, instance = rows.instance_of(row);
            const ShadedEntity& entity = scene.entities[scene.instances[instance].entity];
            const Material& material =
                entity.materials[entity.mesh->vertex_materials[row - rows.first(instance)]];
            const VertexBrdf brdf = vertex_brdf(material, {});
            by_row[row] = brdf.diffuse * diffuse[i] + brdf.specular * specular[i];
        }
    });
    store_radiance(scene, by_row, radiance);
}

}  // namespace haarfield
