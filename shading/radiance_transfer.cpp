#include "shading/radiance_transfer.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <mutex>

#include "shading/vertex_loop.h"

namespace haarfield {

TransferRows::TransferRows(const ShadedScene& scene) : first_(1, 0) {
    for (const ShadedInstance& instance : scene.instances)
        first_.push_back(first_.back() + scene.entities[instance.entity].mesh->positions.size());
}

std::size_t TransferRows::instance_of(std::size_t row) const {
    return static_cast<std::size_t>(std::upper_bound(first_.begin(), first_.end(), row) - first_.begin()) - 1;
}

bool VertexTransfer::look_from(std::size_t instance, std::uint32_t vertex) {
    const ShadedEntity& entity = scene_.entities[scene_.instances[instance].entity];
    const VertexView view = vertex_view(scene_, scene_.instances[instance], vertex);
    brdf = vertex_brdf(entity.materials[entity.mesh->vertex_materials[vertex]], view);
    return visibility_.look(instance, vertex, view);
}

std::span<const WaveletBlock<3>> VertexTransfer::product(const LightPyramid& light) {
    vertex_transfer(light, geometry_.directions, brdf, visibility_.cones(), visibility_.trees(),
                    settings_.depth, memory_, product_);
    return product_;
}

Rgb VertexTransfer::radiance(const LightPyramid& light, int depth) {
    return vertex_radiance(light, geometry_.directions, brdf, visibility_.cones(), visibility_.trees(), depth,
                           memory_);
}

Result<Done> make_rows(const ShadedScene& scene, std::size_t block_rows,
                       const std::function<BlockMaker()>& make_maker, const Progress& progress) {
    const TransferRows rows(scene);
    std::mutex progress_mutex;
    std::uint64_t done = 0;
    tbb::enumerable_thread_specific<BlockMaker> makers(make_maker);
    tbb::parallel_for(std::size_t(0), (rows.count() + block_rows - 1) / block_rows, [&](std::size_t block) {
        const BlockMaker& make = makers.local();
        const std::size_t first = block * block_rows, end = std::min(rows.count(), first + block_rows);
        for (std::size_t row = first; row < end; ++row) {
            if (progress.stop.stop_requested()) return;
            const std::size_t instance = rows.instance_of(row), vertex = row - rows.first(instance);
            if (scene.entities[scene.instances[instance].entity].occlusion->samples().buried[vertex])
                make.add_buried();
            else
                make.add_row(row, instance, static_cast<std::uint32_t>(vertex));
        }
        make.complete(block);
        if (!progress.report) return;
        const std::lock_guard lock(progress_mutex);
        done += end - first;
        progress.report("radiance transfer", done, rows.count());
    });
    if (progress.stop.stop_requested()) return Error{"", interrupted};
    return Done{};
}

void store_radiance(const ShadedScene& scene, std::span<const Rgb> by_row, VertexRadiance& radiance) {
    const TransferRows rows(scene);
    radiance.resize(scene.instances.size());
    tbb::parallel_for(std::size_t(0), scene.instances.size(), [&](std::size_t i) {
        const ShadedEntity& entity = scene.entities[scene.instances[i].entity];
        radiance[i].resize(entity.mesh->positions.size());
        std::transform(
            by_row.begin() + static_cast<std::ptrdiff_t>(rows.first(i)),
            by_row.begin() + static_cast<std::ptrdiff_t>(rows.first(i + 1)), radiance[i].begin(),
            [](const Rgb& r) { return Rgb(std::max(r.x, 0.0f), std::max(r.y, 0.0f), std::max(r.z, 0.0f)); });
        fill_buried(*entity.mesh, entity.occlusion->samples().buried, radiance[i]);
    });
}

}  // namespace haarfield
