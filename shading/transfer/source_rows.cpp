#include "shading/transfer/source_rows.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace haarfield {
namespace {

constexpr std::size_t run = 64;  ///< Rows.

/// Rows [first, end) that are wanted and not buried, with what light finds there.
struct RowRun {
    std::vector<std::uint32_t> rows;
    std::vector<SourceReceiver> receivers;

    RowRun(const ShadedScene& scene, const VertexRows& all, std::size_t first, std::size_t end,
           const VertexMask* wanted) {
        for (std::size_t row = first; row < end; ++row) {
            const InstanceVertex at = all[row];
            if (all.is_buried(at) || (wanted && !(*wanted)[at.instance][at.vertex])) continue;
            const ShadedInstance& instance = scene.instances[at.instance];
            const ShadedEntity& entity = scene.entities[instance.entity];
            const SurfacePoint point = surface_point(entity, at.vertex);
            rows.push_back(static_cast<std::uint32_t>(row));
            receivers.push_back(
                {instance.placement.point_to_world(point.sample),
                 vertex_brdf(entity.materials[point.material], vertex_view(scene, instance, point))});
        }
    }
};

template <class Act>
Result<Done> for_each_run(const VertexRows& rows, const Progress& progress, const Act& act) {
    tbb::parallel_for(std::size_t(0), (rows.count() + run - 1) / run, [&](std::size_t block) {
        if (progress.stop.stop_requested()) return;
        act(block, block * run, std::min(rows.count(), (block + 1) * run));
    });
    if (progress.stop.stop_requested()) return Error{"", interrupted};
    return Done{};
}

}  // namespace

Result<Done> add_source_rows(const ShadedScene& scene, const ShadingGeometry& geometry,
                             std::span<const DirectionalLight> lights, std::span<Rgb> by_row,
                             const VertexMask* wanted, const Progress& progress, std::span<Rgb> diffuse) {
    if (lights.empty()) return Done{};
    const VertexRows rows(scene, geometry);
    return for_each_run(rows, progress, [&](std::size_t, std::size_t first, std::size_t end) {
        const RowRun here(scene, rows, first, end, wanted);
        std::array<Rgb, run> added, added_diffuse;
        added.fill(Rgb(0.0f));
        added_diffuse.fill(Rgb(0.0f));
        const std::size_t count = here.rows.size();
        add_source_light(geometry.rays, lights, here.receivers, std::span(added).first(count),
                         std::span(added_diffuse).first(diffuse.empty() ? 0 : count));
        for (std::size_t k = 0; k < count; ++k) by_row[here.rows[k]] += added[k];
        for (std::size_t k = 0; k < count && !diffuse.empty(); ++k) diffuse[here.rows[k]] += added_diffuse[k];
    });
}

std::size_t SourceSights::bytes() const {
    std::size_t sum = 0;
    for (const std::vector<Sight>& block : blocks) sum += block.size() * sizeof(Sight);
    return sum;
}

Result<SourceSights> source_sights(const ShadedScene& scene, const ShadingGeometry& geometry,
                                   std::span<const LightSource> sources, std::span<Rgb> diffuse,
                                   const Progress& progress) {
    const VertexRows rows(scene, geometry);
    SourceSights result;
    if (sources.empty()) return result;
    result.blocks.resize((rows.count() + run - 1) / run);
    const Result<Done> found =
        for_each_run(rows, progress, [&](std::size_t block, std::size_t first, std::size_t end) {
            const RowRun here(scene, rows, first, end, nullptr);
            const std::size_t count = here.rows.size();
            for (const LightSource& source : sources) {
                std::array<LitPart, run> lit;
                add_lit_parts(geometry.rays, source.lights, here.receivers, std::span(lit).first(count));
                for (std::size_t k = 0; k < count; ++k) {
                    if (lit[k].irradiance == Rgb(0.0f)) continue;
                    diffuse[here.rows[k]] += here.receivers[k].brdf.diffuse * lit[k].by_cosine;
                    if (here.receivers[k].brdf.specular != Rgb(0.0f))
                        result.blocks[block].push_back(
                            {here.rows[k], {lit[k].direction.normalized(), lit[k].irradiance}});
                }
            }
        });
    if (!found) return found.error();
    return result;
}

Result<Done> add_source_highlights(const SourceSights& sights, const ShadedScene& scene,
                                   const ShadingGeometry& geometry, std::span<Rgb> by_row,
                                   const VertexMask* wanted, const Progress& progress) {
    if (sights.blocks.empty()) return Done{};
    const VertexRows rows(scene, geometry);
    return for_each_run(rows, progress, [&](std::size_t block, std::size_t, std::size_t) {
        for (const auto& [row, light] : sights.blocks[block]) {
            const InstanceVertex at = rows[row];
            if (wanted && !(*wanted)[at.instance][at.vertex]) continue;
            const ShadedInstance& instance = scene.instances[at.instance];
            const ShadedEntity& entity = scene.entities[instance.entity];
            const SurfacePoint point = surface_point(entity, at.vertex);
            VertexBrdf brdf =
                vertex_brdf(entity.materials[point.material], vertex_view(scene, instance, point));
            brdf.diffuse = Rgb(0.0f);
            by_row[row] += reflectance(brdf, light.direction) * light.irradiance;
        }
    });
}

}  // namespace haarfield
