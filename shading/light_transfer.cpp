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

/// Makes the two rows of each vertex of a block.
class LightBlockMaker {
public:
    explicit LightBlockMaker(const Frame& frame)
        : frame_(frame),
          vertex_(frame.scene, frame.geometry, frame.settings),
          pruning_(frame.settings.face_size, frame.spectrum),
          rows_(frame.settings.face_size, 1) {}

    void add_row(std::size_t instance, std::uint32_t vertex) {
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
                pruning_.append_channel(term, allowed / weights[term], rows_);
            else
                rows_.append_empty();
    }

    void add_buried() {
        for (int term = 0; term < 2; ++term) rows_.append_empty();
    }

    SparseColumns complete() {
        SparseColumns columns(rows_);
        rows_.clear();
        return columns;
    }

private:
    const Frame& frame_;
    VertexTransfer vertex_;
    ProductPruning pruning_;
    SparseVectors rows_;
};

RgbCubemapTree white_light() {
    RgbCubemapTree white;
    for (RgbQuadtree& face : white.faces) face.scaling = Rgb(1.0f);
    return white;
}

VertexBrdf brdf_of_row(const ShadedScene& scene, const TransferRows& rows, std::size_t row) {
    const std::size_t instance = rows.instance_of(row);
    const ShadedEntity& entity = scene.entities[scene.instances[instance].entity];
    return vertex_brdf(entity.materials[entity.mesh->vertex_materials[row - rows.first(instance)]], {});
}

/// Of the vectors with their materials' colours, over one row in sixteen.
CoefficientSpectrum transfer_spectrum(const ShadedScene& scene, std::span<const SparseColumns> blocks,
                                      int face_size) {
    const TransferRows rows(scene);
    const BlockNumbers numbers(face_size);
    SpectrumEnergies energies{};
    std::vector<double> weights(2 * LightTransfer::block_rows);
    for (std::size_t b = 0; b < blocks.size(); b += 16) {
        for (std::size_t i = 0; i < blocks[b].scale.size(); ++i) {
            const VertexBrdf brdf = brdf_of_row(scene, rows, b * LightTransfer::block_rows + i / 2);
            weights[i] = energy(i % 2 == 0 ? brdf.diffuse : brdf.specular) * squared(blocks[b].scale[i]);
        }
        blocks[b].for_each([&](std::uint32_t index, std::uint16_t row, float value) {
            const std::size_t place =
                spectrum_place(level_of_block(numbers, index / wide_cells), index % wide_cells);
            energies[place] += weights[row] * squared(value);
        });
    }
    return root_mean_squares(energies, 1);
}

}  // namespace

std::size_t LightTransfer::bytes() const {
    std::size_t sum = 0;
    for (const SparseColumns& block : blocks) sum += block.bytes();
    return sum;
}

Result<LightTransfer> light_transfer(const ShadedScene& scene, const ShadingGeometry& geometry,
                                     const RenderSettings& settings, const TransferSettings& transfer,
                                     const DenseCoefficients& typical, const Progress& progress) {
    LightTransfer result;
    result.blocks.resize((TransferRows(scene).count() + LightTransfer::block_rows - 1) /
                         LightTransfer::block_rows);
    result.pruning_error = transfer.pruning_error;
    const Frame frame{scene,
                      geometry,
                      settings,
                      LightPyramid(white_light(), settings.face_size),
                      rms_spectrum(typical),
                      squared(transfer.pruning_error)};
    const Result<Done> made = make_rows(
        scene, LightTransfer::block_rows,
        [&]() -> BlockMaker {
            const auto maker = std::make_shared<LightBlockMaker>(frame);
            return {[maker](std::size_t, std::size_t instance, std::uint32_t vertex) {
                        maker->add_row(instance, vertex);
                    },
                    [maker] { maker->add_buried(); },
                    [maker, &result](std::size_t block) { result.blocks[block] = maker->complete(); }};
        },
        progress);
    if (!made) return made.error();
    result.spectrum = transfer_spectrum(scene, result.blocks, settings.face_size);
    return result;
}

void transfer_light(const LightTransfer& transfer, const ShadedScene& scene, const DenseCoefficients& light,
                    VertexRadiance& radiance) {
    const FewCoefficients few = largest_coefficients(light, transfer.spectrum, transfer.pruning_error / 8);
    const TransferRows rows(scene);
    std::vector<Rgb> by_row(rows.count());
    tbb::parallel_for(std::size_t(0), transfer.blocks.size(), [&](std::size_t b) {
        const SparseColumns& block = transfer.blocks[b];
        std::array<std::array<float, 4>, 2 * LightTransfer::block_rows> sums{};
        add_inner_products(block, few, std::span(sums).first(block.scale.size()));
        for (std::size_t i = 0; i < block.scale.size(); i += 2) {
            const std::size_t row = b * LightTransfer::block_rows + i / 2;
            const VertexBrdf brdf = brdf_of_row(scene, rows, row);
            const auto term = [&](std::size_t k) {
                return Rgb(sums[k][0], sums[k][1], sums[k][2]) * block.scale[k];
            };
            by_row[row] = brdf.diffuse * term(i) + brdf.specular * term(i + 1);
        }
    });
    store_radiance(scene, by_row, radiance);
}

}  // namespace haarfield
