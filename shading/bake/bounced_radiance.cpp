#include "shading/bake/bounced_radiance.h"

#include <algorithm>
#include <cassert>

#include "fields/base/parallel_loop.h"
#include "shading/bake/mesh_point.h"
#include "shading/scene/vertex_loop.h"
#include "shading/visibility/placed_solids.h"
#include "shading/visibility/vertex_rows.h"

namespace haarfield {
namespace {

Outgoing outgoing(const PointShading& shading, std::size_t instance, const SurfacePoint& point,
                  const Rgb& irradiance) {
    const ShadingPoint at = shading_point(shading.scene, shading.scene.instances[instance], point);
    return shading.indirect->outgoing(shading.scene, at.from, at.brdf, irradiance);
}

std::shared_ptr<const FineSurface> placed_surface(const ShadedScene& scene, const BounceRays* before) {
    if (!before) return std::make_shared<const FineSurface>(scene);
    const auto surface = std::make_shared<FineSurface>(*before->surface);
    surface->place(scene);
    return surface;
}

/// Triangles whose part of the scene's light is smaller get no detail, and neither do more than these.
constexpr double least_uneven_share = 1e-5;
constexpr std::size_t most_uneven_triangles = 700;

/// Bounces the direct light of rows, and refines the rays where light is uneven.
Result<BouncedLight> refined_bounces(const PointShading& direct, std::span<const Rgb> by_row,
                                     const FineSurface& surface, LightTransport& transport,
                                     const Progress& progress) {
    const std::vector<Rgb> reflectances = row_reflectances(direct.scene, direct.geometry);
    const BounceSettings& bounces = direct.settings.bounces;
    HF_TRY(const BouncedLight bounced, bounced_light(transport, reflectances, by_row, bounces, progress));
    HF_TRY_DONE(
        transport.refine(direct.scene, direct.geometry, surface, bounced.radiance, reflectances, progress));
    return bounced_light(transport, reflectances, by_row, bounces, progress);
}

/// Returns the diffuse radiance by direct light, with tints, by row. [W/(m^2 sr)]
std::vector<Rgb> direct_rows(const PointShading& direct, const VertexRows& rows,
                             const SceneRadiance& radiance) {
    return tinted_rows(direct.scene, rows, row_values(rows, diffuse_component(radiance)));
}

/// Evaluates direct light inside the triangles where it is most uneven.
///
/// by_vertex  direct light at the vertices, with tints. [W/(m^2 sr)]
Result<DirectDetail> direct_detail(const PointShading& direct, const SceneColours& by_vertex,
                                   const Progress& progress) {
    const ShadedScene& scene = direct.scene;
    DirectDetail detail;
    for (const ShadedInstance& instance : scene.instances)
        detail.places.emplace_back(scene.entities[instance.entity].mesh->triangles.size(), -1);
    struct Cell {
        std::size_t index;  // Of DirectDetail::differences.
        Rgb tint, interpolated;
    };
    std::vector<Cell> wanted;
    std::vector<InstancePoint> points;
    std::int32_t divided = 0;
    for (const auto& [i, t] : uneven_triangles(scene, by_vertex, least_uneven_share, most_uneven_triangles)) {
        const ShadedEntity& entity = scene.entities[scene.instances[i].entity];
        const std::size_t first = std::size_t(divided) * DirectDetail::cells;
        detail.places[i][t] = divided++;
        for (std::size_t cell = 0; cell < DirectDetail::cells; ++cell) {
            const std::array<float, 3> weights = DirectDetail::centre(cell);
            const std::optional<SurfacePoint> at = surface_point(entity, {i, t, weights[1], weights[2]});
            if (!at) continue;
            const std::array<std::uint32_t, 3>& corners = entity.mesh->triangles[t];
            Cell added{first + cell, entity.tints.empty() ? Rgb(1.0f) : Rgb(0.0f), Rgb(0.0f)};
            for (std::size_t c = 0; c < 3; ++c) {
                if (!entity.tints.empty()) added.tint += entity.tints[corners[c]] * weights[c];
                added.interpolated += by_vertex[i][corners[c]] * weights[c];
            }
            wanted.push_back(added);
            points.push_back({i, *at});
        }
    }
    detail.differences.assign(std::size_t(divided) * DirectDetail::cells, Rgb(0.0f));
    HF_TRY(const std::vector<Outgoing> exact, point_radiance(direct, points, progress));
    for (std::size_t k = 0; k < wanted.size(); ++k)
        detail.differences[wanted[k].index] = exact[k].diffuse * wanted[k].tint - wanted[k].interpolated;
    return detail;
}

}  // namespace

Result<BounceRays> bounce_rays(const ShadedScene& scene, const ShadingGeometry& geometry,
                               const RenderSettings& settings, const Progress& progress,
                               const BounceRays* before) {
    const std::shared_ptr<const FineSurface> surface = placed_surface(scene, before);
    if (progress.stop.stop_requested()) return interruption();
    HF_TRY(LightTransport transport,
           LightTransport::make(scene, geometry, *surface, settings.bounces.directions, progress));
    return BounceRays{surface, std::move(transport)};
}

std::vector<Rgb> tinted_rows(const ShadedScene& scene, const VertexRows& rows, std::vector<Rgb> diffuse) {
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const std::span<const Rgb> tints = scene.entities[scene.instances[i].entity].tints;
        for (std::size_t k = 0; k < tints.size(); ++k)
            diffuse[rows.first(i) + k] *= tints[rows.vertices(i)[k]];
    }
    return diffuse;
}

Result<IndirectLight> scene_indirect_light(const PointShading& direct, const SceneRadiance& radiance,
                                           const BounceRays& rays, const Progress& progress) {
    const VertexRows rows(direct.scene, direct.geometry);
    LightTransport transport = rays.transport;
    HF_TRY(BouncedLight bounced,
           refined_bounces(direct, direct_rows(direct, rows, radiance), *rays.surface, transport, progress));
    return indirect_light(direct.scene, direct.geometry, rays.surface, transport, std::move(bounced));
}

Result<IndirectLight> focused_indirect_light(const PointShading& direct, const SceneRadiance& radiance,
                                             const BounceRays& rays, const Progress& progress) {
    assert(!direct.indirect);
    LightTransport transport = rays.transport;
    const VertexRows rows(direct.scene, direct.geometry);
    const std::vector<Rgb> by_row = direct_rows(direct, rows, radiance);
    SceneColours by_vertex;
    store_radiance(direct.scene, direct.geometry, by_row, by_vertex);
    // As indirect_light() does it: differences inside triangles are relative to the colours of the corners.
    fill_hidden(direct.scene, direct.geometry, transport.hidden(), by_vertex);
    HF_TRY(DirectDetail detail, direct_detail(direct, by_vertex, progress));
    average_detail(direct.scene, detail, by_vertex);
    const std::vector<Rgb> averaged = row_values(rows, by_vertex);
    HF_TRY(BouncedLight bounced, refined_bounces(direct, averaged, *rays.surface, transport, progress));
    for (std::size_t row = 0; row < by_row.size(); ++row)
        bounced.radiance[row] += by_row[row] - averaged[row];
    IndirectLight result =
        indirect_light(direct.scene, direct.geometry, rays.surface, transport, std::move(bounced));
    result.lit = std::make_shared<const LitSurface>(direct.scene, result.radiance, std::move(detail));
    return result;
}

Result<IndirectLight> scene_indirect_light(const PointShading& direct, const SceneRadiance& radiance,
                                           const Progress& progress) {
    HF_TRY(const BounceRays rays, bounce_rays(direct.scene, direct.geometry, direct.settings, progress));
    return scene_indirect_light(direct, radiance, rays, progress);
}

Result<IndirectLight> scene_indirect_light(const PointShading& direct, const Progress& progress) {
    HF_TRY(const SceneRadiance radiance, scene_radiance(direct, progress));
    return scene_indirect_light(direct, radiance, progress);
}

Result<SceneRadiance> bounced_radiance(const PointShading& direct, std::optional<IndirectLight>& indirect,
                                       const Progress& progress) {
    assert(!direct.indirect);
    indirect.reset();
    Result<SceneRadiance> radiance = scene_radiance(direct, progress);
    if (!radiance || is_partial(direct.sharing)) return radiance;
    const PlacedFill fill(direct.scene);
    if (direct.settings.bounces.most == 0) {
        fill(*radiance);
        return radiance;
    }
    HF_TRY(indirect, scene_indirect_light(direct, *radiance, progress));
    PointShading lit = direct;
    lit.indirect = &*indirect;
    HF_TRY_DONE(add_indirect_radiance(lit, *radiance, progress));
    fill(*radiance);
    return radiance;
}

Result<std::vector<Outgoing>> indirect_radiance(const PointShading& shading,
                                                std::span<const InstancePoint> points,
                                                const Progress& progress) {
    assert(shading.indirect);
    std::vector<Outgoing> result(points.size());
    HF_TRY_DONE(parallel_loop(
        {points.size(), 64},
        [&]() -> LoopBody {
            return [&](std::size_t k) {
                const auto& [instance, point, ignored] = points[k];
                result[k] = outgoing(shading, instance, point,
                                     shading.indirect->irradiance_at(shading.scene, instance, point));
            };
        },
        "indirect light", progress));
    return result;
}

Result<Done> gather_irradiance(const PointShading& direct, const VertexMask& wanted, IndirectLight& indirect,
                               const Progress& progress) {
    const ShadedScene& scene = direct.scene;
    indirect.nearness.clear();
    for (const std::vector<Rgb>& values : indirect.irradiance)
        indirect.nearness.emplace_back(values.size(), GatheredIrradiance().nearness);
    return visit_vertices(
        scene, direct.geometry.orders(),
        [&]() -> VertexVisitor {
            return [&](std::size_t instance, std::uint32_t vertex) {
                if (!wanted[instance][vertex]) return;
                const GatheredIrradiance found = indirect.gathered_at(
                    scene, instance, surface_point(scene.entities[scene.instances[instance].entity], vertex));
                indirect.irradiance[instance][vertex] = found.irradiance;
                indirect.nearness[instance][vertex] = found.nearness;
            };
        },
        "indirect light", progress);
}

Result<Done> add_indirect_radiance(const PointShading& shading, SceneRadiance& radiance,
                                   const Progress& progress) {
    assert(shading.indirect);
    const ShadedScene& scene = shading.scene;
    HF_TRY_DONE(visit_vertices(
        scene, shading.geometry.orders(),
        [&]() -> VertexVisitor {
            return [&](std::size_t instance, std::uint32_t vertex) {
                radiance[instance][vertex] +=
                    outgoing(shading, instance,
                             surface_point(scene.entities[scene.instances[instance].entity], vertex),
                             shading.indirect->irradiance[instance][vertex]);
            };
        },
        "indirect light", progress));
    for (std::size_t i = 0; i < radiance.size(); ++i)
        shading.geometry.entities[scene.instances[i].entity].fill(radiance[i]);
    return Done{};
}

}  // namespace haarfield
