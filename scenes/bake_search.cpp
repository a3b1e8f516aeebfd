#include "scenes/bake_search.h"

#include <fmt/format.h>

#include <algorithm>

namespace haarfield {
namespace {

/// Objects per scene up to which all are rasterized at each point.
constexpr std::size_t most_rasterized = 8;

/// Points on all surfaces. They must be many, because the reported interval is that of the error at them.
constexpr std::size_t area_point_count = 262144;

void add_colours(const SceneEntities& entities, const ShadedScene& shaded,
                 std::vector<DisplayedPoint>& points) {
    for (DisplayedPoint& point : points) {
        const SceneEntity& entity = *entities.entities[shaded.instances[point.at.instance].entity];
        const Mesh& mesh = entity.mesh.fine;
        const auto& corners = mesh.triangles[point.at.triangle];
        const Surface& surface = entity.surfaces[mesh.vertex_materials[corners[0]]];
        if (!surface.texture && !surface.coloured) continue;
        const std::array<float, 3> weights = point.at.weights();
        const auto mean = [&](const auto& values) {
            return values[corners[0]] * weights[0] + values[corners[1]] * weights[1] +
                   values[corners[2]] * weights[2];
        };
        Rgb colour(1.0f);
        if (surface.texture) colour *= surface.texture->colour_at(mean(mesh.uvs));
        if (surface.coloured) colour *= mean(mesh.colours);
        const float tinted = surface.has_separate_specular() ? surface.tinted_specular : 1;
        point.diffuse = colour;
        point.specular = colour * tinted + Rgb(1 - tinted);
    }
}

std::size_t wanted_vertices(const Scene& scene) {
    std::size_t vertices = 0;
    for (const Instance& instance : scene.instances)
        vertices += scene.entities[instance.entity].fine_vertices;
    return vertices;
}

}  // namespace

std::vector<std::uint32_t> search_starts(std::optional<std::size_t> vertex_budget) {
    const std::size_t finer = std::min(search_vertices, vertex_budget.value_or(search_vertices)) / 2;
    if (finer < 4 * search_start_vertices) return {search_start_vertices};
    return {search_start_vertices, std::uint32_t(finer)};
}

Scene search_start(const Scene& scene, std::uint32_t vertices) {
    Scene start = scene;
    const double share = double(vertices) / double(std::max<std::size_t>(1, wanted_vertices(scene)));
    if (share < 1 || vertices > search_start_vertices)
        for (Entity& entity : start.entities)
            entity.fine_vertices = std::uint32_t(double(entity.fine_vertices) * share);
    return start;
}

Result<BakedScene> repeated_bake(const BakeOptions& options, const BakeAttempt& attempt) {
    if (!options.error) return attempt({}, options);
    const std::vector<std::uint32_t> starts = search_starts(options.vertex_budget);
    BakeOptions chosen = options;
    for (std::size_t n = 0;; ++n) {
        chosen.stops_early = n + 1 < starts.size();
        HF_TRY(BakedScene baked, attempt(starts[n], chosen));
        if (!baked.search || !baked.search->is_stopped) return baked;
    }
}

FieldExtent search_fields(const Scene& scene, Occlusion occlusion) {
    return occlusion == Occlusion::fields || scene.instances.size() > most_rasterized
               ? FieldExtent::surroundings
               : FieldExtent::none;
}

std::size_t search_budget(const Scene& scene, const SceneEntities& entities) {
    return std::max({search_vertices, usual_vertex_budget(entities), wanted_vertices(scene)});
}

std::vector<DisplayedPoint> displayed_points(const SceneEntities& entities, const ShadedScene& shaded,
                                             std::span<const std::optional<MeshPoint>> pixels) {
    std::vector<DisplayedPoint> points;
    for (std::size_t k = 0; k < pixels.size(); ++k)
        if (pixels[k]) points.push_back({*pixels[k], Rgb(1.0f), Rgb(1.0f), static_cast<std::uint32_t>(k)});
    add_colours(entities, shaded, points);
    return points;
}

std::vector<DisplayedPoint> displayed_area(const SceneEntities& entities, const ShadedScene& shaded) {
    std::vector<DisplayedPoint> points = area_points(shaded, area_point_count);
    add_colours(entities, shaded, points);
    return points;
}

std::string reason_of(SearchEnd end, std::size_t vertex_budget) {
    switch (end) {
        case SearchEnd::reached: break;
        case SearchEnd::vertex_budget:
            return fmt::format("the budget of {} vertices is used up; a larger --vertex-budget helps",
                               vertex_budget);
        case SearchEnd::short_edges: return "the largest errors are at edges that are too short to be split";
        case SearchEnd::little_gain:
            return "more vertices hardly reduce the error; --worst shows where it is largest";
        case SearchEnd::direct_light:
            return "the error is in the direct light at the vertices; a larger --face-size or more "
                   "coarse_triangles in the scene file may help, and `budget` names the cause";
        case SearchEnd::indirect_light:
            return "the error is in the indirect light, which more vertices do not reduce; --bounces 0 "
                   "leaves indirect light out";
    }
    return {};
}

}  // namespace haarfield
