#include "shading/transfer/specular_hits.h"

#include <tbb/parallel_for.h>

#include <cmath>

#include "fields/base/parallel_loop.h"
#include "shading/bake/renderer.h"
#include "shading/bounces/hidden_rows.h"
#include "shading/bounces/lobe_rays.h"

namespace haarfield {
namespace {

constexpr float whole = 65535;  ///< Of Hit::fraction.

bool is_wanted(const VertexMask* wanted, const InstanceVertex& at) {
    return !wanted || (*wanted)[at.instance][at.vertex] != 0;
}

}  // namespace

Result<SpecularHits> SpecularHits::make(const ShadedScene& scene, const ShadingGeometry& geometry,
                                        const FineSurface& surface, std::span<const std::uint8_t> hidden,
                                        const VertexMask* wanted, const Progress& progress) {
    SpecularHits result;
    std::vector<std::uint32_t> first_material;
    bool has_metals = false;
    for (const ShadedEntity& entity : scene.entities) {
        first_material.push_back(static_cast<std::uint32_t>(result.materials_.size()));
        for (const Material& material : entity.materials) {
            const VertexBrdf brdf = surface_brdf<float>(material);
            result.materials_.push_back({brdf.specular, brdf.metallic});
            has_metals = has_metals || brdf.metallic != Rgb(0.0f);
        }
    }
    const VertexRows rows(scene, geometry);
    std::vector<std::uint32_t> specular;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const ShadedEntity& entity = scene.entities[scene.instances[i].entity];
        for (std::size_t k = 0; k < rows.vertices(i).size(); ++k) {
            const InstanceVertex at{i, rows.vertices(i)[k]};
            if (entity.materials[entity.mesh->vertex_materials[at.vertex]].specular != Rgb(0.0f) &&
                !hidden[rows.first(i) + k] && is_wanted(wanted, at))
                specular.push_back(static_cast<std::uint32_t>(rows.first(i) + k));
        }
    }
    if (specular.empty()) return result;
    const std::vector<std::vector<std::uint32_t>> places = row_places(scene, geometry);
    // The corners of a triangle that is hit; without weight if all of them are hidden.
    const auto hit_at = [&](const SurfaceHit& hit, float weight) {
        const std::size_t entity = scene.instances[hit.instance].entity;
        const auto& triangle = scene.entities[entity].mesh->triangles[hit.triangle];
        Hit made{};
        for (std::size_t k = 0; k < 3; ++k)
            made.rows[k] = static_cast<std::uint32_t>(rows.first(hit.instance) + places[entity][triangle[k]]);
        const std::array<float, 3> weights = open_weights(hit, made.rows, hidden);
        const float open = weights[0] + weights[1] + weights[2];
        if (!(open > 0)) return made;
        for (std::size_t k = 0; k < 2; ++k)
            made.fraction[k] = static_cast<std::uint16_t>(
                std::lround(std::min(1.0f, std::max(0.0f, weights[k + 1] / open)) * whole));
        made.weight = weight;
        return made;
    };
    result.blocks_.resize((specular.size() + block_rows - 1) / block_rows);
    const auto trace = [&](std::size_t b) {
        Block& block = result.blocks_[b];
        const std::size_t begin = b * block_rows, end = std::min(specular.size(), begin + block_rows);
        for (std::size_t k = begin; k < end; ++k) {
            const InstanceVertex at = rows[specular[k]];
            const ShadedInstance& instance = scene.instances[at.instance];
            const ShadedEntity& entity = scene.entities[instance.entity];
            const ShadingPoint point = shading_point(scene, instance, at.vertex);
            std::array<LobeRay, FineSurface::packet> rays;
            std::array<Vec3f, FineSurface::packet> directions;
            std::size_t count = 0;
            const auto trace_packet = [&] {
                const FineSurface::Hits hits =
                    surface.first_hits(scene, point.from, std::span(directions).first(count));
                for (std::size_t r = 0; r < count; ++r) {
                    if (!hits[r] || hits[r]->is_back) continue;
                    const Hit made = hit_at(*hits[r], rays[r].weight);
                    if (made.weight == 0) continue;
                    block.hits.push_back(made);
                    if (has_metals) block.metallic.push_back(rays[r].metallic);
                }
                count = 0;
            };
            visit_lobe_rays(point.brdf, [&](const LobeRay& ray) {
                rays[count] = ray;
                directions[count] = ray.direction;
                if (++count == rays.size()) trace_packet();
            });
            trace_packet();
            block.rows.push_back(
                {specular[k], static_cast<std::uint32_t>(block.hits.size()),
                 first_material[instance.entity] + entity.mesh->vertex_materials[at.vertex]});
        }
        block.hits.shrink_to_fit();
        block.metallic.shrink_to_fit();
    };
    HF_TRY_DONE(parallel_loop(
        {result.blocks_.size()}, [&]() -> LoopBody { return trace; }, "specular reflections",
        counted_by(block_rows, specular.size(), progress)));
    return result;
}

void SpecularHits::reflect(std::span<const Rgb> radiance, std::span<Rgb> reflected, std::size_t first,
                           std::size_t stride) const {
    tbb::parallel_for(std::size_t(0), blocks_.size(), [&](std::size_t b) {
        const Block& block = blocks_[b];
        for (std::size_t r = first; r < block.rows.size(); r += stride) {
            const Row& row = block.rows[r];
            Rgb sum(0.0f), by_metal(0.0f);
            for (std::size_t h = r > 0 ? block.rows[r - 1].end : 0; h < row.end; ++h) {
                const Hit& hit = block.hits[h];
                const float v = float(hit.fraction[0]) / whole, w = float(hit.fraction[1]) / whole;
                const Rgb arriving = (radiance[hit.rows[0]] * std::max(0.0f, 1 - v - w) +
                                      radiance[hit.rows[1]] * v + radiance[hit.rows[2]] * w) *
                                     hit.weight;
                sum += arriving;
                if (!block.metallic.empty()) by_metal += arriving * block.metallic[h];
            }
            const Reflectance& material = materials_[row.material];
            reflected[row.row] = material.specular * (sum - material.metallic * by_metal);
        }
    });
}

std::size_t SpecularHits::bytes() const {
    std::size_t sum = 0;
    for (const Block& block : blocks_)
        sum += block.rows.size() * sizeof(Row) + block.hits.size() * sizeof(Hit) +
               block.metallic.size() * sizeof(float);
    return sum;
}

}  // namespace haarfield
