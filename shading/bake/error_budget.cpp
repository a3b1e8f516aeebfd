#include "shading/bake/error_budget.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "fields/base/parallel_loop.h"
#include "fields/base/random_choice.h"
#include "shading/bake/bounced_radiance.h"
#include "shading/bake/path_tracer.h"
#include "shading/bake/ray_renderer.h"
#include "shading/bake/vertex_oracles.h"

namespace haarfield {
namespace {

/// Collects the errors of points and the radiance that they are relative to.
class ErrorSum {
public:
    void add(const Rgb& found, const Rgb& exact, const Rgb& oracle) {
        const Vec3d error = Vec3d(found) - Vec3d(exact), radiance(oracle);
        squares_.push_back(error.dot(error));
        energy_ += radiance.dot(radiance);
        error_ += error.x + error.y + error.z;
        radiance_ += radiance.x + radiance.y + radiance.z;
    }
    BudgetEntry entry(std::string name, std::string meaning, std::size_t points) {
        BudgetEntry result{std::move(name), std::move(meaning), points};
        if (squares_.empty() || energy_ == 0) return result;
        double sum = 0;
        for (const double square : squares_) sum += square;
        std::sort(squares_.begin(), squares_.end());
        const std::size_t rank = (squares_.size() * 99 + 99) / 100 - 1;
        result.relative_rmse = std::sqrt(sum / energy_);
        result.relative_99 = std::sqrt(squares_[rank] * double(squares_.size()) / energy_);
        result.bias = error_ / radiance_;
        return result;
    }

private:
    std::vector<double> squares_;
    double energy_ = 0, error_ = 0, radiance_ = 0;
};

std::vector<BudgetVertex> random_vertices(const ShadedScene& scene, std::size_t wanted) {
    std::vector<BudgetVertex> all;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const std::vector<std::uint8_t>& buried =
            scene.entities[scene.instances[i].entity].occlusion->samples().buried;
        for (std::size_t v = 0; v < buried.size(); ++v)
            if (!buried[v]) all.push_back({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(v)});
    }
    keep_random(all, wanted);
    return all;
}

std::vector<BudgetEntry> budget_entries(const std::vector<OracleRadiances>& radiances,
                                        const OracleContext& context) {
    struct Row {
        const char* name;
        std::string meaning;
        Rgb OracleRadiances::*found;
        Rgb OracleRadiances::*exact;
        bool OracleRadiances::*acts = nullptr;
    };
    using R = OracleRadiances;
    const int size = context.light.face_size, fine = context.fine_light.face_size;
    const Row rows[] = {
        {"resolution", fmt::format("cubemaps of {0} x {0} texels, compared with {1} x {1}", size, fine),
         &R::oracle, &R::finer},
        {"coarse mesh", "simplified occluders, compared with the original meshes", &R::oracle, &R::original},
        {"lighting",
         context.settings.light_coefficients > 0
             ? fmt::format("{} wavelets per face", context.settings.light_coefficients)
             : "all wavelets",
         &R::lighting, &R::oracle},
        {"sources",
         fmt::format("{} directions of suns and patches of emitters, compared with all {} of their parts",
                     context.baked_light.lights.size(), context.light.parts.size()),
         &R::sources, &R::oracle},
        {"visibility", "truncated wavelets of the fields, one byte per cell", &R::visibility, &R::oracle},
        {"planar field", "interpolation between exact samples on the ground", &R::planar, &R::oracle,
         &R::has_planar},
        {"spherical field", "interpolation between exact samples around the object", &R::spherical,
         &R::oracle, &R::has_spherical},
        {"impostors", "silhouettes of distant objects", &R::distant, &R::oracle, &R::has_distant},
        {"lobes", "BRDF and cosine evaluated by cells, as in the walk", &R::lobes, &R::oracle},
        {"depth",
         context.settings.depth < full_depth ? fmt::format("depth {}", context.settings.depth) : "all levels",
         &R::shallow, &R::lobes},
        {"all at the vertices", "the bake, compared with the finest oracle", &R::baked, &R::finest}};
    std::vector<BudgetEntry> entries;
    for (const Row& row : rows) {
        ErrorSum errors;
        std::size_t points = 0;
        for (const OracleRadiances& r : radiances) {
            errors.add(r.*row.found, r.*row.exact, row.exact == &R::finest ? r.finest : r.oracle);
            points += !row.acts || r.*row.acts;
        }
        entries.push_back(errors.entry(row.name, row.meaning, points));
    }
    return entries;
}

/// Relative standard deviation at which path tracing of a vertex ends, and the largest number of paths.
constexpr double path_certainty = 0.01;
constexpr std::uint32_t most_paths = 65536;

/// Adds indirect light to the vertices, and its errors to the entries. The total stays the last entry.
Result<Done> add_bounces(const ShadedScene& scene, const OracleContext& context, ErrorBudget& budget,
                         const Progress& progress) {
    const PointShading direct{scene, context.geometry, context.baked_light, context.settings};
    HF_TRY(const IndirectLight indirect, scene_indirect_light(direct, progress));
    const RayScene rays(scene);
    const PathTracer tracer(rays, *indirect.surface);
    struct Bounced {
        Rgb found{0.0f}, exact{0.0f}, deviation{0.0f};
    };
    std::vector<Bounced> bounced(budget.vertices.size());
    HF_TRY_DONE(parallel_loop(
        {bounced.size()},
        [&]() -> LoopBody {
            return [&](std::size_t k) {
                const BudgetVertex& at = budget.vertices[k];
                const ShadedInstance& instance = scene.instances[at.instance];
                const ShadedEntity& entity = scene.entities[instance.entity];
                const SurfacePoint point = surface_point(entity, at.vertex);
                const Rgb diffuse = entity.materials[point.material].diffuse * static_cast<float>(1 / pi);
                const PathTracer::Estimate truth =
                    tracer.indirect_irradiance(instance.placement.point_to_world(point.sample),
                                               instance.placement.direction_to_world(point.normal),
                                               path_certainty, most_paths, static_cast<std::uint32_t>(k));
                bounced[k] = {diffuse * indirect.irradiance[at.instance][at.vertex],
                              diffuse * truth.irradiance, diffuse * truth.deviation};
            };
        },
        "paths", progress));
    ErrorSum errors, without, all;
    double noise = 0, energy = 0;
    for (std::size_t k = 0; k < bounced.size(); ++k) {
        BudgetVertex& vertex = budget.vertices[k];
        vertex.exact += bounced[k].exact;
        vertex.baked += bounced[k].found;
        vertex.deviation = bounced[k].deviation;
        errors.add(bounced[k].found, bounced[k].exact, vertex.exact);
        without.add(Rgb(0.0f), bounced[k].exact, vertex.exact);
        all.add(vertex.baked, vertex.exact, vertex.exact);
        noise += squared(bounced[k].deviation);
        energy += squared(vertex.exact);
    }
    const std::size_t points = bounced.size();
    const BudgetEntry direct_light = std::exchange(budget.entries.back(), {});
    budget.entries.pop_back();
    budget.entries.push_back({"direct light", "the bake without bounces, compared with the finest oracle",
                              points, direct_light.relative_rmse, direct_light.relative_99,
                              direct_light.bias});
    budget.entries.push_back(
        without.entry("no bounces", "direct light only, compared with path tracing", points));
    budget.entries.push_back(errors.entry(
        "bounces",
        fmt::format(
            "{} bounces, {} directions per vertex, compared with path tracing, whose error is {:.2f} %",
            indirect.bounces, context.settings.bounces.directions,
            energy > 0 ? 100 * std::sqrt(noise / energy) : 0.0),
        points));
    budget.entries.push_back(
        all.entry("all at the vertices", "the bake, compared with the finest oracle", points));
    return Done{};
}

}  // namespace

Result<ErrorBudget> error_budget(const ShadedScene& scene, std::span<const Mesh* const> originals,
                                 const RenderSettings& settings, std::size_t vertices,
                                 const Progress& progress) {
    HF_TRY(const ShadingGeometry geometry, shading_geometry(scene, settings, progress));
    const OracleContext context(scene, originals, settings, geometry);
    ErrorBudget budget;
    budget.vertices = random_vertices(scene, vertices);
    std::vector<OracleRadiances> radiances(budget.vertices.size());
    HF_TRY_DONE(parallel_loop(
        {radiances.size()},
        [&]() -> LoopBody {
            return [&, shade = std::make_shared<VertexOracles>(context)](std::size_t k) {
                radiances[k] = (*shade)(budget.vertices[k].instance, budget.vertices[k].vertex);
            };
        },
        "error budget", progress));
    budget.entries = budget_entries(radiances, context);
    for (std::size_t k = 0; k < radiances.size(); ++k) {
        budget.vertices[k].exact = radiances[k].finest;
        budget.vertices[k].baked = budget.vertices[k].direct = radiances[k].baked;
    }
    if (settings.bounces.most > 0) HF_TRY_DONE(add_bounces(scene, context, budget, progress));
    std::ranges::stable_sort(budget.vertices, std::greater(), [](const BudgetVertex& v) {
        const Vec3f error = v.baked - v.exact;
        return error.length2();
    });
    double energy = 0;
    for (const BudgetVertex& vertex : budget.vertices) energy += squared(vertex.exact);
    const auto floor = static_cast<float>(
        0.01 * std::sqrt(energy / double(std::max<std::size_t>(1, budget.vertices.size()))));
    std::ranges::copy_if(budget.vertices, std::back_inserter(budget.wrong), [floor](const BudgetVertex& v) {
        return (v.baked - v.exact).length() > 0.2f * v.exact.length() + floor + 3 * v.deviation.length();
    });
    return budget;
}

Result<BudgetEntry> ray_difference(const ShadedScene& scene, std::span<const BudgetVertex> vertices,
                                   std::uint32_t samples, const Progress& progress) {
    const RayScene rays(scene);
    std::vector<RayEstimate> estimates(vertices.size());
    HF_TRY_DONE(parallel_loop(
        {vertices.size()},
        [&]() -> LoopBody {
            return [&](std::size_t k) {
                estimates[k] = ray_estimate(rays, vertices[k].instance, vertices[k].vertex, samples);
            };
        },
        "rays", progress));
    ErrorSum errors;
    double noise = 0, energy = 0;
    for (std::size_t k = 0; k < vertices.size(); ++k) {
        errors.add(vertices[k].direct, estimates[k].radiance, estimates[k].radiance);
        noise += squared(estimates[k].deviation);
        energy += squared(estimates[k].radiance);
    }
    BudgetEntry entry = errors.entry("rays", {}, vertices.size());
    entry.noise = energy > 0 ? std::sqrt(noise / energy) : 0.0;
    entry.meaning = fmt::format(
        "direct light, against {} rays a vertex; {:.3f} % without their standard error of {:.3f} %", samples,
        100 * entry.without_noise(), 100 * entry.noise);
    return entry;
}

Result<BudgetEntry> interpolation_error(const ShadedScene& scene, std::span<const MeshPoint> points,
                                        const RenderSettings& settings, const Progress& progress) {
    const DenseScene dense(scene, settings.face_size, settings.sources);
    struct Radiances {
        Rgb interpolated{0.0f}, exact{0.0f};
        bool counts = false;
    };
    std::vector<Radiances> radiances(points.size());
    HF_TRY_DONE(parallel_loop(
        {points.size()},
        [&]() -> LoopBody {
            return [&, shader = std::make_shared<DenseShader>(dense)](std::size_t k) {
                const ShadedEntity& entity = scene.entities[scene.instances[points[k].instance].entity];
                const std::optional<SurfacePoint> point = surface_point(entity, points[k]);
                if (!point) return;
                radiances[k].exact = shader->radiance(points[k].instance, *point).total();
                for (std::size_t c = 0; c < 3; ++c)
                    radiances[k].interpolated +=
                        shader
                            ->radiance(points[k].instance,
                                       surface_point(entity, entity.mesh->triangles[points[k].triangle][c]))
                            .total() *
                        points[k].weights()[c];
                radiances[k].counts = true;
            };
        },
        "interpolation error", progress));
    ErrorSum errors;
    std::size_t counted = 0;
    for (const Radiances& r : radiances)
        if (r.counts) {
            errors.add(r.interpolated, r.exact, r.exact);
            ++counted;
        }
    return errors.entry("interpolation", "between the vertices, at the pixels of the picture", counted);
}

}  // namespace haarfield
