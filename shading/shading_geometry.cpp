#include "shading/shading_geometry.h"

namespace haarfield {
namespace {

/// How far from an occluder's ground plane a vertex still counts as on it. [radii of the occluder]
constexpr float on_ground = 2e-3f;

}  // namespace

Result<ShadingGeometry> shading_geometry(const ShadedScene& scene, const RenderSettings& settings,
                                         const Progress& progress) {
    ShadingGeometry geometry{{}, DirectionPyramid(settings.face_size)};
    for (const ShadedEntity& entity : scene.entities) {
        std::vector<std::uint32_t> order = spatial_order(entity.mesh->positions);
        Result<WideVisibility> visibility = WideVisibility::make(*entity.field, order, progress.stop);
        if (!visibility) return visibility.error();
        std::vector<ConvexPolygon> polygons;
        if (entity.occlusion->coarse().triangles.size() <= settings.exact_triangles)
            polygons = convex_polygons(entity.occlusion->coarse());
        geometry.entities.push_back({std::move(order), std::move(*visibility), std::move(polygons)});
    }
    return geometry;
}

bool VertexVisibility::look(std::size_t instance_index, std::uint32_t vertex, const VertexView& view) {
    trees_.clear();
    parts_.clear();
    cones_.clear();
    parts_.reserve(1 + 8 * scene_.instances.size());  // so that spans of them stay
    const auto add_tree = [&](const WideCubemap<std::uint8_t>& tree, float weight) {
        parts_.push_back({&tree, weight});
        trees_.back().parts = {parts_.data() + parts_.size() - trees_.back().parts.size() - 1,
                               trees_.back().parts.size() + 1};
    };
    trees_.emplace_back();
    add_tree(geometry_.entities[scene_.instances[instance_index].entity].visibility.local(vertex), 1);
    for (std::size_t i = 0; i < scene_.instances.size(); ++i) {
        if (i == instance_index) continue;
        const ShadedInstance& other = scene_.instances[i];
        const ShadedEntity& entity = scene_.entities[other.entity];
        const ShadingGeometry::Entity& prepared = geometry_.entities[other.entity];
        const Vec3f point = (view.point - other.translate) / other.scale;
        if (!prepared.polygons.empty()) {
            if (entity.occlusion->coarse().one_sided > 0 && entity.occlusion->in_coarse()(point)) return false;
            add_cones(prepared.polygons, point, cones_);
            continue;
        }
        const VisibilityField& field = *entity.field;
        const float height = (view.position.y - other.translate.y) / other.scale - field.planar.centre.y;
        const bool planar = std::abs(height) <= on_ground * field.bounds.radius();
        const Interpolation samples =
            planar ? field.planar.interpolation(point) : field.spherical.interpolation(point);
        if (samples.count == 0) continue;
        trees_.emplace_back().constant = samples.open;
        for (std::size_t k = 0; k < std::size_t(samples.count); ++k)
            add_tree(planar ? prepared.visibility.planar(samples.sample[k])
                            : prepared.visibility.spherical(samples.sample[k]),
                     samples.weight[k]);
    }
    return true;
}

}  // namespace haarfield
