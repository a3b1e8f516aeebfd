#include "shading/visibility/vertex_rows.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace haarfield {

VertexRows::VertexRows(const ShadedScene& scene, const ShadingGeometry& geometry)
    : scene_(scene), geometry_(geometry), first_(1, 0) {
    for (std::size_t i = 0; i < scene.instances.size(); ++i)
        first_.push_back(first_.back() + vertices(i).size());
}

InstanceVertex VertexRows::operator[](std::size_t row) const {
    const auto after = std::upper_bound(first_.begin(), first_.end(), row);
    const auto instance = static_cast<std::size_t>(after - first_.begin()) - 1;
    return {instance, vertices(instance)[row - first_[instance]]};
}

bool VertexRows::is_buried(const InstanceVertex& vertex) const {
    const ShadedEntity& entity = scene_.entities[scene_.instances[vertex.instance].entity];
    return entity.occlusion->samples().buried[vertex.vertex] != 0;
}

void store_radiance(const ShadedScene& scene, const ShadingGeometry& geometry, std::span<const Rgb> by_row,
                    SceneColours& radiance, const VertexMask* wanted) {
    const VertexRows rows(scene, geometry);
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

std::vector<std::vector<std::uint32_t>> row_places(const ShadedScene& scene,
                                                   const ShadingGeometry& geometry) {
    std::vector<std::vector<std::uint32_t>> result;
    for (std::size_t e = 0; e < scene.entities.size(); ++e) {
        const std::vector<std::uint32_t>& order = geometry.entities[e].order;
        std::vector<std::uint32_t>& place = result.emplace_back(order.size());
        for (std::uint32_t k = 0; k < order.size(); ++k) place[order[k]] = k;
    }
    return result;
}

std::vector<Rgb> row_values(const VertexRows& rows, const SceneColours& values) {
    std::vector<Rgb> by_row;
    by_row.reserve(rows.count());
    for (std::size_t i = 0; i < values.size(); ++i)
        for (const std::uint32_t v : rows.vertices(i)) by_row.push_back(values[i][v]);
    return by_row;
}

}  // namespace haarfield
