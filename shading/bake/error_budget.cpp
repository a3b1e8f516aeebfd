#include "shading/bake/error_budget.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "fields/base/parallel_loop.h"
#include "fields/base/random_choice.h"
#include "shading/bake/vertex_oracles.h"

namespace haarfield {
namespace {

/// Errors of several points, and what they are relative to.
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
        {"resolution", fmt::format("cubemaps of {0} x {0} texels, against {1} x {1}", size, fine), &R::oracle,
         &R::finer},
        {"coarse mesh", "simplified occluders, against the original meshes", &R::oracle, &R::original},
        {"lighting",
         context.settings.light_coefficients > 0
             ? fmt::format("{} wavelets a face", context.settings.light_coefficients)
             : "all wavelets",
         &R::lighting, &R::oracle},
        {"sources",
         fmt::format("{} directions of suns and lamps, against all {} of their parts",
                     context.baked_light.lights.size(), context.light.parts.size()),
         &R::sources, &R::oracle},
        {"visibility", "the fields' truncated wavelets, in bytes", &R::visibility, &R::oracle},
        {"planar field", "interpolated between exact samples on the ground", &R::planar, &R::oracle,
         &R::has_planar},
        {"spherical field", "interpolated between exact samples around", &R::spherical, &R::oracle,
         &R::has_spherical},
        {"impostors", "distant objects, by pictures of their silhouettes", &R::distant, &R::oracle,
         &R::has_distant},
        {"lobes", "BRDF and cosine as the walk evaluates them, on cells", &R::lobes, &R::oracle},
        {"depth",
         context.settings.depth < full_depth || context.settings.tolerance > 0
             ? fmt::format("depth {}, tolerance {}", context.settings.depth, context.settings.tolerance)
             : "all levels",
         &R::shallow, &R::lobes},
        {"all at the vertices", "the bake, against the finest oracle", &R::baked, &R::finest}};
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

}  // namespace

Result<ErrorBudget> error_budget(const ShadedScene& scene, std::span<const Mesh* const> originals,
                                 const RenderSettings& settings, std::size_t vertices,
                                 const Progress& progress) {
    const Result<ShadingGeometry> geometry = shading_geometry(scene, settings, progress);
    if (!geometry) return geometry.error();
    const OracleContext context(scene, originals, settings, *geometry);
    ErrorBudget budget;
    budget.vertices = random_vertices(scene, vertices);
    std::vector<OracleRadiances> radiances(budget.vertices.size());
    const Result<Done> measured = parallel_loop(
        {radiances.size()},
        [&]() -> LoopBody {
            return [&, shade = std::make_shared<VertexOracles>(context)](std::size_t k) {
                radiances[k] = (*shade)(budget.vertices[k].instance, budget.vertices[k].vertex);
            };
        },
        "error budget", progress);
    if (!measured) return measured.error();
    budget.entries = budget_entries(radiances, context);
    for (std::size_t k = 0; k < radiances.size(); ++k) {
        budget.vertices[k].exact = radiances[k].finest;
        budget.vertices[k].baked = radiances[k].baked;
    }
    std::ranges::stable_sort(budget.vertices, std::greater(), [](const BudgetVertex& v) {
        const Vec3f error = v.baked - v.exact;
        return error.length2();
    });
    return budget;
}

Result<BudgetEntry> interpolation_error(const ShadedScene& scene, std::span<const MeshPoint> points,
                                        const RenderSettings& settings, const Progress& progress) {
    const Result<DenseScene> dense =
        DenseScene::make(scene, settings.face_size, settings.sources, progress.stop);
    if (!dense) return dense.error();
    struct Radiances {
        Rgb interpolated{0.0f}, exact{0.0f};
        bool counts = false;
    };
    std::vector<Radiances> radiances(points.size());
    const Result<Done> measured = parallel_loop(
        {points.size()},
        [&]() -> LoopBody {
            return [&, shader = std::make_shared<DenseShader>(*dense)](std::size_t k) {
                const ShadedEntity& entity = scene.entities[scene.instances[points[k].instance].entity];
                const std::optional<SurfacePoint> point = surface_point(entity, points[k]);
                if (!point) return;
                radiances[k].exact = shader->radiance(points[k].instance, *point);
                for (std::size_t c = 0; c < 3; ++c)
                    radiances[k].interpolated +=
                        shader->radiance(
                            points[k].instance,
                            surface_point(entity, entity.mesh->triangles[points[k].triangle][c])) *
                        points[k].weights()[c];
                radiances[k].counts = true;
            };
        },
        "interpolation error", progress);
    if (!measured) return measured.error();
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
