#include "shading/transfer/light_transfer.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <memory>

#include "shading/transfer/group_pruning.h"

namespace haarfield {
namespace {

struct LightContext {
    const ShadedScene& scene;
    const ShadingGeometry& geometry;
    const RenderSettings& settings;
    const LightTransfer& transfer;
    CoefficientSpectrum spectrum;
    double error;
};

LightTransfer::Colours colours_of(const Material& material) {
    const VertexBrdf brdf = surface_brdf<float>(material);
    return {brdf.diffuse, brdf.specular * (Rgb(1.0f) - brdf.metallic), brdf.specular * brdf.metallic};
}

/// Lists the factors of the vectors.
void list_colours(const ShadedScene& scene, const VertexRows& rows, LightTransfer& transfer) {
    std::vector<std::size_t> first;
    for (const ShadedEntity& entity : scene.entities) {
        first.push_back(transfer.colours.size());
        for (const Material& material : entity.materials) transfer.colours.push_back(colours_of(material));
    }
    const bool has_metals = std::ranges::any_of(
        transfer.colours, [](const LightTransfer::Colours& colours) { return colours[2] != Rgb(0.0f); });
    transfer.terms = has_metals ? 3 : 2;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const std::size_t entity = scene.instances[i].entity;
        for (const std::uint32_t vertex : rows.vertices(i)) {
            transfer.colour_of_row.push_back(static_cast<std::uint32_t>(
                first[entity] + scene.entities[entity].mesh->vertex_materials[vertex]));
        }
    }
}

/// Makes the columns of a block, group by group.
template <int terms>
class LightBlockMaker {
public:
    explicit LightBlockMaker(const LightContext& context)
        : context_(context),
          numbers_(context.settings.face_size),
          vertex_(context.scene, context.geometry, context.settings),
          pruning_(context.settings.face_size, context.spectrum) {}

    void add_row(std::size_t row, const InstanceVertex& vertex) {
        if (vertex_.look_from(vertex)) {
            vertex_.terms(numbers_, pruning_.product(rows_));
            const auto& colours = context_.transfer.colours[context_.transfer.colour_of_row[row]];
            std::array<float, terms> weights;
            for (std::size_t term = 0; term < terms; ++term)
                weights[term] = static_cast<float>(squared(colours[term]));
            pruning_.set_weights(rows_, weights);
        }
        next_row();
    }

    void add_buried() { next_row(); }

    GroupedColumns complete() {
        if (rows_ > 0) complete_group();
        GroupedColumns columns(context_.settings.face_size, indices_, entries_, std::move(scales_));
        indices_.clear();
        entries_.clear();
        scales_.clear();
        return columns;
    }

private:
    void next_row() {
        if (++rows_ == group_rows) complete_group();
    }
    void complete_group() {
        pruning_.append(context_.error, scales_.size(), indices_, entries_, scales_);
        pruning_.clear();
        rows_ = 0;
    }

    const LightContext& context_;
    const BlockNumbers numbers_;
    VertexTransfer vertex_;
    GroupPruning<terms> pruning_;
    std::size_t rows_ = 0;  ///< Rows in the current group.
    std::vector<std::uint32_t> indices_;
    std::vector<GroupEntry> entries_;
    std::vector<float> scales_;
};

template <int terms>
BlockMaker block_maker(const LightContext& context, LightTransfer& result) {
    const auto maker = std::make_shared<LightBlockMaker<terms>>(context);
    return {[maker](std::size_t row, const InstanceVertex& vertex) { maker->add_row(row, vertex); },
            [maker] { maker->add_buried(); },
            [maker, &result](std::size_t block) { result.blocks[block] = maker->complete(); }};
}

/// Returns the spectrum of the vectors with their materials' colours, over one group in eight of one block in
/// eight.
CoefficientSpectrum transfer_spectrum(const LightTransfer& transfer, int face_size) {
    constexpr std::size_t stride = 8;
    const BlockNumbers numbers(face_size);
    SpectrumEnergies energies{};
    double rows = 0;
    for (std::size_t b = 0; b < transfer.blocks.size(); b += stride) {
        const GroupedColumns& block = transfer.blocks[b];
        const auto weight = [&](std::size_t group, std::size_t k) {
            const std::size_t row = b * transfer.block_rows() + group / transfer.terms * group_rows + k;
            if (row >= transfer.colour_of_row.size()) return 0.0;
            return squared(transfer.colours[transfer.colour_of_row[row]][group % transfer.terms]);
        };
        for (std::uint32_t index = 0; index + 1 < block.first.size(); ++index)
            for (std::uint32_t i = block.first[index]; i < block.first[index + 1]; ++i) {
                const GroupEntry& entry = block.entry[i];
                if (entry.group / transfer.terms % stride != 0) continue;
                const double scale = squared(entry_step(entry.exponent) * block.scale[entry.group]);
                double& sum = energies[spectrum_place(numbers, index)];
                for (std::size_t k = 0; k < group_rows; ++k)
                    sum += weight(entry.group, k) * scale * squared(entry.value[k]);
            }
        rows += double(block.scale.size() / transfer.terms * group_rows) / stride;
    }
    return rows > 0 ? root_mean_squares(energies, 3 * rows) : CoefficientSpectrum{};
}

}  // namespace

std::size_t LightTransfer::bytes() const {
    std::size_t sum = colour_of_row.size() * sizeof colour_of_row[0] + sources.bytes();
    for (const GroupedColumns& block : blocks) sum += block.bytes();
    return sum;
}

Result<LightTransfer> light_transfer(const ShadedScene& scene, const ShadingGeometry& geometry,
                                     const RenderSettings& settings, const TransferSettings& transfer,
                                     const DenseCoefficients& typical, const Progress& progress) {
    const VertexRows rows(scene, geometry);
    LightTransfer result;
    list_colours(scene, rows, result);
    result.blocks.resize((rows.count() + result.block_rows() - 1) / result.block_rows());
    result.pruning_error = transfer.pruning_error;
    CoefficientSpectrum spectrum = rms_spectrum(typical);
    // Darkness says nothing about subsequent light.
    if (std::ranges::all_of(spectrum, [](float amplitude) { return amplitude == 0; })) spectrum.fill(1);
    const LightContext context{scene, geometry, settings, result, spectrum, double(transfer.pruning_error)};
    HF_TRY_DONE(make_rows(
        rows, result.block_rows(),
        [&] { return result.terms == 3 ? block_maker<3>(context, result) : block_maker<2>(context, result); },
        progress));
    result.spectrum = transfer_spectrum(result, settings.face_size);
    HF_TRY(result.sources, SourceRows::make(scene, geometry, progress));
    return result;
}

Result<Done> shade_rows(const LightTransfer& transfer, const ShadowRays& rays, const DenseCoefficients& light,
                        std::span<const DirectionalLight> lights, FrameQuality quality,
                        std::vector<Rgb>& radiance, std::vector<Rgb>* diffuse, const Progress& progress) {
    const SelectedCoefficients few =
        largest_coefficients(light, transfer.spectrum, transfer.pruning_error / 8);
    radiance.resize(transfer.colour_of_row.size());
    if (diffuse) diffuse->resize(radiance.size());
    tbb::parallel_for(std::size_t(0), transfer.blocks.size(), [&](std::size_t b) {
        if (progress.stop.stop_requested()) return;
        const GroupedColumns& block = transfer.blocks[b];
        std::array<GroupSums, GroupedColumns::most_groups> all_sums{};
        const std::span sums = std::span(all_sums).first(block.scale.size());
        add_inner_products(block, few, sums);
        const std::size_t first = b * transfer.block_rows(),
                          end = std::min(radiance.size(), first + transfer.block_rows());
        for (std::size_t row = first; row < end; ++row) {
            const LightTransfer::Colours& colours = transfer.colours[transfer.colour_of_row[row]];
            const std::size_t place = row - first, group = place / group_rows * transfer.terms;
            Rgb sum(0.0f);
            for (std::size_t t = 0; t < transfer.terms; ++t) {
                const auto& [red, green, blue] = sums[group + t];
                const std::size_t k = place % group_rows;
                sum += colours[t] * Rgb(red[k], green[k], blue[k]) * block.scale[group + t];
                if (t == 0 && diffuse) (*diffuse)[row] = without_negative(sum);
            }
            radiance[row] = sum;
        }
    });
    if (progress.stop.stop_requested()) return interruption();
    return transfer.sources.add(rays, lights, quality, radiance,
                                diffuse ? std::span(*diffuse) : std::span<Rgb>(), progress);
}

Result<Done> shade_frame(const LightTransfer& transfer, const ShadedScene& scene,
                         const ShadingGeometry& geometry, const DenseCoefficients& light,
                         std::span<const DirectionalLight> lights, FrameQuality quality,
                         SceneColours& radiance, const Progress& progress) {
    std::vector<Rgb> by_row;
    HF_TRY_DONE(shade_rows(transfer, geometry.rays, light, lights, quality, by_row, nullptr, progress));
    store_radiance(scene, geometry, by_row, radiance);
    return Done{};
}

}  // namespace haarfield
