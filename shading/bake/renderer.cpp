#include "shading/bake/renderer.h"

#include <algorithm>
#include <memory>

#include "fields/base/parallel_loop.h"
#include "shading/bake/bounced_radiance.h"
#include "shading/bake/clustered_light.h"
#include "shading/bake/emitter_light.h"
#include "shading/bake/lamp_light.h"
#include "shading/scene/vertex_loop.h"
#include "shading/walk/vertex_shading.h"

namespace haarfield {
namespace {

/// Shades runs of neighbouring points, on one thread.
class PointShader {
public:
    explicit PointShader(const PointShading& shading)
        : shading_(shading), visibility_(shading.scene, shading.geometry) {}

    /// Adds a point to the run.
    void add(const InstancePoint& added) {
        const auto& [instance, point, irradiance] = added;
        const ShadingPoint& at = take_up(instance, point);
        shade_if(visibility_.look(instance, point, at));
        if (shading_.indirect)
            add_indirect(irradiance ? *irradiance
                                    : shading_.indirect->irradiance_at(shading_.scene, instance, point));
    }

    /// Adds a vertex to the run.
    void add(std::size_t instance, std::uint32_t vertex) {
        const ShadedEntity& entity = shading_.scene.entities[shading_.scene.instances[instance].entity];
        const VisibilityProduct* kept =
            shading_.visibility ? shading_.visibility->find(instance, vertex) : nullptr;
        const ShadingPoint& at = take_up(instance, surface_point(entity, vertex));
        if (!kept)
            shade_if(visibility_.look(instance, vertex, at));
        else if (kept->trees.empty())
            shade_if(false);
        else
            shade(*kept);
        if (shading_.indirect) add_indirect(shading_.indirect->irradiance[instance][vertex]);
    }

    /// Ends the run and returns the radiance of its points, valid until the next run ends.
    std::span<const Outgoing> finish() {
        const ShadowRays& rays = shading_.geometry.rays;
        if (shading_.light.clusters.empty())
            add_source_light(rays, shading_.light.lights, receivers_, radiance_);
        else
            add_clustered_light(rays, shading_.light.clusters, receivers_, radiance_);
        add_lamp_light(rays, shading_.light.lamps, receivers_, radiance_);
        add_emitter_light(rays, shading_.light.emitters, receivers_, radiance_);
        finished_.swap(radiance_);
        radiance_.clear();
        receivers_.clear();
        return finished_;
    }

private:
    const ShadingPoint& take_up(std::size_t instance, const SurfacePoint& point) {
        return receivers_.emplace_back(
            shading_point(shading_.scene, shading_.scene.instances[instance], point));
    }
    void shade_if(bool sees) {
        if (sees) return shade(visibility_.visibility());
        radiance_.emplace_back();
    }
    void shade(const VisibilityProduct& visibility) {
        radiance_.push_back(without_negative(outgoing_radiance(
            shading_.light.smooth,
            {shading_.geometry.directions, receivers_.back().brdf, visibility, shading_.settings.depth},
            memory_)));
    }
    /// Adds indirect light to the last point.
    void add_indirect(const Rgb& irradiance) {
        const ShadingPoint& receiver = receivers_.back();
        radiance_.back() +=
            shading_.indirect->outgoing(shading_.scene, receiver.from, receiver.brdf, irradiance);
    }

    const PointShading shading_;
    VertexVisibility visibility_;
    WalkMemory<std::uint8_t> memory_;
    std::vector<ShadingPoint> receivers_;        ///< The points of the current run.
    std::vector<Outgoing> radiance_, finished_;  ///< By point, of the current and of the last run.
};

}  // namespace

Result<SceneRadiance> scene_radiance(const PointShading& shading, const Progress& progress) {
    const ShadedScene& scene = shading.scene;
    const std::vector<std::span<const std::uint32_t>> orders = shading.geometry.orders();
    SceneRadiance radiance;
    const auto shade = [&](const VertexMask* wanted) {
        return visit_wanted_runs(
            scene, orders, wanted,
            [&]() -> VertexRunVisitor {
                return [&, shader = std::make_shared<PointShader>(shading)](
                           std::size_t instance, std::span<const std::uint32_t> vertices) {
                    // Runs are shaded as a whole, so that results do not depend on the process that shades
                    // them.
                    for (const std::uint32_t vertex : vertices) {
                        if (progress.stop.stop_requested()) return;
                        shader->add(instance, vertex);
                    }
                    const std::span<const Outgoing> run = shader->finish();
                    for (std::size_t k = 0; k < vertices.size(); ++k)
                        radiance[instance][vertices[k]] = run[k];
                };
            },
            "shading", progress);
    };
    HF_TRY_DONE(share_vertices(shading.sharing, scene, orders, radiance, shade));
    if (is_partial(shading.sharing)) return radiance;
    for (std::size_t i = 0; i < radiance.size(); ++i)
        shading.geometry.entities[scene.instances[i].entity].fill(radiance[i]);
    return radiance;
}

Result<SceneRadiance> scene_radiance(const ShadedScene& scene, const RenderSettings& settings,
                                     const Progress& progress) {
    HF_TRY(ShadingGeometry geometry, shading_geometry(scene, settings, progress));
    const SceneLight light = scene_light(scene, settings, progress.stop);
    std::optional<IndirectLight> indirect;
    return bounced_radiance({scene, geometry, light, settings}, indirect, progress);
}

Result<std::vector<Outgoing>> point_radiance(const PointShading& shading,
                                             std::span<const InstancePoint> points,
                                             const Progress& progress) {
    std::vector<Outgoing> radiance(points.size());
    constexpr std::size_t run = 64;
    const auto shade = [&](std::size_t first_point, std::size_t last_point) {
        const std::size_t first_run = first_point / run, last_run = (last_point + run - 1) / run;
        return parallel_loop(
            {last_run - first_run},
            [&, first_run]() -> LoopBody {
                return [&, first_run, shader = std::make_shared<PointShader>(shading)](std::size_t r) {
                    const std::size_t begin = (first_run + r) * run,
                                      end = std::min(points.size(), begin + run);
                    for (std::size_t i = begin; i != end; ++i) {
                        if (progress.stop.stop_requested()) return;
                        shader->add(points[i]);
                    }
                    std::ranges::copy(shader->finish(),
                                      radiance.begin() + static_cast<std::ptrdiff_t>(begin));
                };
            },
            "shading", counted_by(run, last_point - first_point, progress));
    };
    HF_TRY_DONE(share_points(shading.sharing, radiance, shade));
    return radiance;
}

}  // namespace haarfield
