#include "shading/scene/vertex_loop.h"

#include <algorithm>

#include "fields/base/parallel_loop.h"

namespace haarfield {

namespace {

/// Largest distance by which a vertex is moved towards the centre of its object. [m]
constexpr float most_drawn = 1e-3f;

}  // namespace

SurfacePoint surface_point(const ShadedEntity& entity, std::uint32_t vertex) {
    return {entity.mesh->positions[vertex], entity.mesh->normals[vertex],
            entity.occlusion->samples().points[vertex], entity.mesh->vertex_materials[vertex]};
}

Vec3f mirrored_view(const Vec3f& eye, const Vec3f& position, const Vec3f& normal) {
    Vec3f to_eye = (eye - position).normalized();
    const float facing = to_eye.dot(normal);
    if (facing < 0) to_eye = (to_eye - normal * facing).normalized();
    return (normal * (2 * std::max(facing, 0.0f)) - to_eye).normalized();
}

ShadingPoint shading_point(const ShadedScene& scene, const ShadedInstance& instance,
                           const SurfacePoint& point) {
    const ShadedEntity& entity = scene.entities[instance.entity];
    const Vec3f normal = instance.placement.direction_to_world(point.normal),
                position = instance.placement.point_to_world(point.position),
                towards = entity.occlusion->coarse().bounds().centre() - point.sample;
    const float distance = towards.length(),
                step = std::min({distance, 1e-3f * entity.occlusion->coarse().bounds().radius(),
                                 most_drawn / instance.placement.scale});
    const Vec3f drawn = distance > 0 ? point.sample + towards * (step / distance) : point.sample;
    return {position, instance.placement.point_to_world(point.sample),
            instance.placement.point_to_world(drawn),
            surface_brdf<float>(entity.materials[point.material], normal,
                                mirrored_view(scene.eye, position, normal))};
}

ShadingPoint shading_point(const ShadedScene& scene, const ShadedInstance& instance, std::uint32_t vertex) {
    return shading_point(scene, instance, surface_point(scene.entities[instance.entity], vertex));
}

std::vector<std::uint32_t> spatial_order(std::span<const Vec3f> points) {
    const Bounds bounds = bounds_of(points);
    constexpr int bits = 20;
    const Vec3f size = bounds.upper - bounds.lower;
    const float cells_per_metre = ((1 << bits) - 1) / std::max({size.x, size.y, size.z, 1e-20f});
    std::vector<std::pair<std::uint64_t, std::uint32_t>> places;
    for (std::size_t i = 0; i < points.size(); ++i) {
        std::uint64_t place = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const auto cell =
                static_cast<std::uint32_t>((points[i][axis] - bounds.lower[axis]) * cells_per_metre);
            for (int bit = 0; bit < bits; ++bit) place |= std::uint64_t(cell >> bit & 1u) << (3 * bit + axis);
        }
        places.emplace_back(place, static_cast<std::uint32_t>(i));
    }
    std::sort(places.begin(), places.end());
    std::vector<std::uint32_t> order;
    for (const auto& [place, index] : places) order.push_back(index);
    return order;
}

Result<Done> visit_vertices(const ShadedScene& scene, std::span<const std::span<const std::uint32_t>> orders,
                            const std::function<VertexVisitor()>& make_visitor, std::string_view stage,
                            const Progress& progress) {
    return visit_vertex_runs(
        scene, orders,
        [&]() -> VertexRunVisitor {
            return [visit = make_visitor(), &progress](std::size_t instance,
                                                       std::span<const std::uint32_t> vertices) {
                for (const std::uint32_t v : vertices) {
                    if (progress.stop.stop_requested()) return;
                    visit(instance, v);
                }
            };
        },
        stage, progress);
}

Result<Done> visit_vertex_runs(const ShadedScene& scene,
                               std::span<const std::span<const std::uint32_t>> orders,
                               const std::function<VertexRunVisitor()>& make_visitor, std::string_view stage,
                               const Progress& progress) {
    constexpr std::size_t run = 64;
    std::vector<std::size_t> first(1, 0);  // First run of each instance.
    std::size_t vertices = 0;
    for (const ShadedInstance& instance : scene.instances) {
        first.push_back(first.back() + (orders[instance.entity].size() + run - 1) / run);
        vertices += orders[instance.entity].size();
    }
    return parallel_loop(
        {first.back()},
        [&]() -> LoopBody {
            return [&, visit = make_visitor()](std::size_t item) {
                const auto after = std::upper_bound(first.begin(), first.end(), item);
                const auto instance = static_cast<std::size_t>(after - first.begin()) - 1;
                const std::size_t entity = scene.instances[instance].entity;
                const std::span<const std::uint8_t> buried =
                    scene.entities[entity].occlusion->samples().buried;
                const std::size_t begin = (item - first[instance]) * run;
                std::array<std::uint32_t, run> seen;
                std::size_t count = 0;
                for (const std::uint32_t v :
                     orders[entity].subspan(begin, std::min(run, orders[entity].size() - begin)))
                    if (!buried[v]) seen[count++] = v;
                if (count > 0) visit(instance, std::span<const std::uint32_t>(seen).first(count));
            };
        },
        stage, counted_by(run, vertices, progress));
}

SceneRadiance black_vertices(const ShadedScene& scene) {
    SceneRadiance radiance;
    for (const ShadedInstance& instance : scene.instances)
        radiance.emplace_back(scene.entities[instance.entity].mesh->positions.size());
    return radiance;
}

}  // namespace haarfield
