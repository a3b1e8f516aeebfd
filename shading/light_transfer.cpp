#include "shading/light_transfer.h"

#include <tbb/parallel_for.h>

#include <algorithm>
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

constexpr std::size_t most_terms = 3;

/// What each term is multiplied with: diffuse, highlights, highlights times F. [1/sr]
std::array<Rgb, most_terms> term_colours(const VertexBrdf& brdf) {
    return {brdf.diffuse, brdf.specular * (Rgb(1.0f) - brdf.metallic), brdf.specular * brdf.metallic};
}

bool has_metals(const ShadedScene& scene) {
    return std::ranges::any_of(scene.entities, [](const ShadedEntity& entity) {
        return std::ranges::any_of(entity.materials, [](const Material& material) {
            return vertex_brdf(material, {}).metallic != Rgb(0.0f);
        });
    });
}

/// Makes the rows of each vertex of a block, one for each term.
class LightBlockMaker {
public:
    LightBlockMaker(const Frame& frame, std::size_t terms)
        : frame_(frame),
          terms_(terms),
          vertex_(frame.scene, frame.geometry, frame.settings),
          pruning_(frame.settings.face_size, frame.spectrum),
          rows_(frame.settings.face_size, 1) {}

    void add_row(const InstanceVertex& vertex) {
        std::array<double, most_terms> weights{};
        if (vertex_.look_from(vertex)) {
            const std::array<Rgb, most_terms> colours = term_colours(vertex_.brdf);
            std::ranges::transform(colours, weights.begin(), energy);
            // Under white light, the terms in a channel each.
            vertex_.brdf.diffuse = weights[0] > 0 ? Rgb(1, 0, 0) : Rgb(0.0f);
            vertex_.brdf.specular = Rgb(0, weights[1] > 0 ? 1 : 0, weights[2] > 0 ? 1 : 0);
            vertex_.brdf.metallic = Rgb(0, 0, 1);
            pruning_.take_channels(vertex_.product(frame_.white));
        }
        // An equal share of the error for each of them.
        double allowed = 0;
        for (std::size_t term = 0; term < terms_; ++term)
            allowed += weights[term] * pruning_.channel_energy(term) * frame_.allowed / double(terms_);
        for (std::size_t term = 0; term < terms_; ++term)
            if (weights[term] > 0)
                pruning_.append_channel(term, allowed / weights[term], rows_);
            else
                rows_.append_empty();
    }

    void add_buried() {
        for (std::size_t term = 0; term < terms_; ++term) rows_.append_empty();
    }

    SparseColumns complete() {
        SparseColumns columns(rows_);
        rows_.clear();
        return columns;
    }

private:
    const Frame& frame_;
    const std::size_t terms_;
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
    const InstanceVertex at = rows[row];
    const ShadedEntity& entity = scene.entities[scene.instances[at.instance].entity];
    return vertex_brdf(entity.materials[entity.mesh->vertex_materials[at.vertex]], {});
}

/// Of the vectors with their materials' colours, over one row in sixteen.
CoefficientSpectrum transfer_spectrum(const ShadedScene& scene, const TransferRows& rows,
                                      std::span<const SparseColumns> blocks, std::size_t terms,
                                      int face_size) {
    const BlockNumbers numbers(face_size);
    SpectrumEnergies energies{};
    std::vector<double> weights(terms * LightTransfer::block_rows);
    for (std::size_t b = 0; b < blocks.size(); b += 16) {
        for (std::size_t i = 0; i < blocks[b].scale.size(); ++i) {
            const VertexBrdf brdf = brdf_of_row(scene, rows, b * LightTransfer::block_rows + i / terms);
            weights[i] = energy(term_colours(brdf)[i % terms]) * squared(blocks[b].scale[i]);
        }
        blocks[b].for_each([&](std::uint32_t index, std::uint16_t row, float value) {
            const std::size_t place = spectrum_place(numbers, index);
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
    const TransferRows rows(scene, geometry);
    LightTransfer result;
    result.terms = has_metals(scene) ? 3 : 2;
    result.blocks.resize((rows.count() + LightTransfer::block_rows - 1) / LightTransfer::block_rows);
    result.pruning_error = transfer.pruning_error;
    const Frame frame{scene,
                      geometry,
                      settings,
                      LightPyramid(white_light(), settings.face_size),
                      rms_spectrum(typical),
                      squared(transfer.pruning_error)};
    const Result<Done> made = make_rows(
        rows, LightTransfer::block_rows,
        [&]() -> BlockMaker {
            const auto maker = std::make_shared<LightBlockMaker>(frame, result.terms);
            return {[maker](std::size_t, const InstanceVertex& vertex) { maker->add_row(vertex); },
                    [maker] { maker->add_buried(); },
                    [maker, &result](std::size_t block) { result.blocks[block] = maker->complete(); }};
        },
        progress);
    if (!made) return made.error();
    result.spectrum = transfer_spectrum(scene, rows, result.blocks, result.terms, settings.face_size);
    return result;
}

Result<Done> transfer_light(const LightTransfer& transfer, const ShadedScene& scene,
                            const ShadingGeometry& geometry, const DenseCoefficients& light,
                            VertexRadiance& radiance, const Progress& progress) {
    const FewCoefficients few = largest_coefficients(light, transfer.spectrum, transfer.pruning_error / 8);
    const TransferRows rows(scene, geometry);
    std::vector<Rgb> by_row(rows.count(), Rgb(0.0f));
    tbb::parallel_for(std::size_t(0), transfer.blocks.size(), [&](std::size_t b) {
        if (progress.stop.stop_requested()) return;
        const SparseColumns& block = transfer.blocks[b];
        std::array<std::array<float, 4>, most_terms * LightTransfer::block_rows> sums{};
        add_inner_products(block, few, std::span(sums).first(block.scale.size()));
        for (std::size_t i = 0; i < block.scale.size(); i += transfer.terms) {
            const std::size_t row = b * LightTransfer::block_rows + i / transfer.terms;
            const std::array<Rgb, most_terms> colours = term_colours(brdf_of_row(scene, rows, row));
            for (std::size_t term = 0; term < transfer.terms; ++term) {
                const std::array<float, 4>& sum = sums[i + term];
                by_row[row] += colours[term] * Rgb(sum[0], sum[1], sum[2]) * block.scale[i + term];
            }
        }
    });
    if (progress.stop.stop_requested()) return Error{"", interrupted};
    store_radiance(scene, geometry, by_row, radiance);
    return Done{};
}

}  // namespace haarfield
