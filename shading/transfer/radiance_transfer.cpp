#include "shading/transfer/radiance_transfer.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

#include "fields/base/parallel_loop.h"
#include "shading/scene/vertex_loop.h"

namespace haarfield {

TransferRows::TransferRows(const ShadedScene& scene, const ShadingGeometry& geometry)
    : scene_(scene), geometry_(geometry), first_(1, 0) {
    for (std::size_t i = 0; i < scene.instances.size(); ++i)
        first_.push_back(first_.back() + vertices(i).size());
}

InstanceVertex TransferRows::operator[](std::size_t row) const {
    const auto after = std::upper_bound(first_.begin(), first_.end(), row);
    const auto instance = static_cast<std::size_t>(after - first_.begin()) - 1;
    return {instance, vertices(instance)[row - first_[instance]]};
}

bool TransferRows::is_buried(const InstanceVertex& vertex) const {
    const ShadedEntity& entity = scene_.entities[scene_.instances[vertex.instance].entity];
    return entity.occlusion->samples().buried[vertex.vertex] != 0;
}

bool VertexTransfer::look_from(const InstanceVertex& at) {
    const ShadedInstance& instance = scene_.instances[at.instance];
    const ShadedEntity& entity = scene_.entities[instance.entity];
    const VertexView view = vertex_view(scene_, instance, at.vertex);
    brdf = vertex_brdf(entity.materials[entity.mesh->vertex_materials[at.vertex]], view);
    return visibility_.look(at.instance, at.vertex, view);
}

std::span<const WaveletBlock<3>> VertexTransfer::product(const LightPyramid& light,
                                                         const DetailWeights* detail) {
    blurred_energy_ = radiance_integrand(light, shaded(settings_.depth), memory_, product_, detail);
    return product_;
}

std::span<const WaveletBlock<3>> VertexTransfer::highlights(const LightPyramid& light, Rgb& diffuse,
                                                            const DetailWeights* detail) {
    const HighlightIntegrand found =
        highlight_integrand(light, shaded(settings_.depth), memory_, product_, detail);
    blurred_energy_ = found.blurred_energy;
    diffuse = found.diffuse;
    return product_;
}

Rgb VertexTransfer::radiance(const LightPyramid& light, int depth) {
    return outgoing_radiance(light, shaded(depth), memory_);
}

Result<Done> make_rows(const TransferRows& rows, std::size_t block_rows,
                       const std::function<BlockMaker()>& make_maker, const Progress& progress) {
    return parallel_loop(
        {rows.count(), block_rows},
        [&]() -> LoopBody {
            return [&, make = make_maker()](std::size_t row) {
                const InstanceVertex vertex = rows[row];
                if (rows.is_buried(vertex))
                    make.add_buried();
                else
                    make.add_row(row, vertex);
                if ((row + 1) % block_rows == 0 || row + 1 == rows.count()) make.complete(row / block_rows);
            };
        },
        "radiance transfer", progress);
}

void store_radiance(const ShadedScene& scene, const ShadingGeometry& geometry, std::span<const Rgb> by_row,
                    SceneRadiance& radiance, const VertexMask* wanted) {
    const TransferRows rows(scene, geometry);
    radiance.resize(scene.instances.size());
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const std::span<const std::uint32_t> vertices = rows.vertices(i);
        const std::span<const Rgb> values = by_row.subspan(rows.first(i), vertices.size());
        radiance[i].resize(vertices.size(), Rgb(0.0f));
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, vertices.size(), 4096), [&](const auto& range) {
            for (std::size_t k = range.begin(); k != range.end(); ++k)
                if (!wanted || (*wanted)[i][vertices[k]])
                    radiance[i][vertices[k]] = without_negative(values[k]);
        });
    }
    tbb::parallel_for(std::size_t(0), radiance.size(),
                      [&](std::size_t i) { geometry.entities[scene.instances[i].entity].fill(radiance[i]); });
}

}  // namespace haarfield
