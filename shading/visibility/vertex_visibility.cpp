#include "shading/visibility/vertex_visibility.h"

#include <algorithm>
#include <tuple>

namespace haarfield {

void VertexVisibility::add_tree(const WideCubemap<std::uint8_t>& tree, float weight) {
    parts_.push_back({&tree, weight});
    const std::size_t count = trees_.back().parts.size() + 1;
    trees_.back().parts = {parts_.data() + parts_.size() - count, count};
}

bool VertexVisibility::look(std::size_t instance_index, const WideCubemap<std::uint8_t>& own,
                            const VertexView& view) {
    trees_.clear();
    parts_.clear();
    cones_.clear();
    candidates_.clear();
    rasterized_.clear();
    const std::span<const std::uint32_t> near = geometry_.grid.near(view.point);
    parts_.reserve(2 + 8 * near.size());  // so that spans of them stay
    trees_.emplace_back();
    add_tree(own, 1);
    for (const std::uint32_t i : near)
        if (i != instance_index && !look_past(i, view)) return false;
    if (!candidates_.empty()) rasterize(view);
    return true;
}

bool VertexVisibility::look_past(std::uint32_t instance, const VertexView& view) {
    const ShadedInstance& other = scene_.instances[instance];
    const ShadedEntity& entity = scene_.entities[other.entity];
    const ShadingGeometry::Entity& prepared = geometry_.entities[other.entity];
    const VisibilityField& field = *entity.field;
    if (is_below_horizon(entity, other, view)) return true;

    const float distance = squared_exact_distance(prepared, field, other, view);
    if (!(distance < 1) || (prepared.polygons.empty() && !rasterizes_)) {
        look_up(other, view);
        return true;
    }
    const Vec3f point = other.placement.point_to_object(view.point);
    if (entity.occlusion->coarse().one_sided() > 0 && entity.occlusion->in_coarse()(point)) return false;
    if (prepared.polygons.empty())
        candidates_.push_back({distance, instance});
    else
        add_cones(prepared.polygons, point, cones_);
    return true;
}

void VertexVisibility::look_up(const ShadedInstance& other, const VertexView& view) {
    const WideVisibility& visibility = geometry_.entities[other.entity].visibility;
    const auto [planar, samples] = field_lookup(*scene_.entities[other.entity].field, other, view);
    if (samples.count == 0) return;
    trees_.emplace_back().constant = samples.open;
    for (std::size_t k = 0; k < std::size_t(samples.count); ++k)
        add_tree(planar ? visibility.planar(samples.sample[k]) : visibility.spherical(samples.sample[k]),
                 samples.weight[k]);
}

void VertexVisibility::rasterize(const VertexView& view) {
    if (candidates_.size() > geometry_.most_rasterized) {
        const auto end = candidates_.begin() + std::ptrdiff_t(geometry_.most_rasterized);
        std::nth_element(candidates_.begin(), end, candidates_.end(),
                         [](const Candidate& a, const Candidate& b) {
                             return std::tie(a.distance, a.instance) < std::tie(b.distance, b.instance);
                         });
        // The order in which factors are multiplied is not left to the library.
        std::sort(end, candidates_.end(),
                  [](const Candidate& a, const Candidate& b) { return a.instance < b.instance; });
        for (auto farther = end; farther != candidates_.end(); ++farther)
            look_up(scene_.instances[farther->instance], view);
        candidates_.erase(end, candidates_.end());
    }
    for (const Candidate& candidate : candidates_) {
        const ShadedInstance& other = scene_.instances[candidate.instance];
        const Occluder& occluder = scene_.entities[other.entity].occlusion->coarse();
        const Vec3f point = other.placement.point_to_object(view.point);
        // Finding what lies below the horizon has a cost, too.
        const bool mostly_below = (occluder.bounds().centre() - point).dot(view.normal) < 0;
        rasterized_.push_back({&occluder, point, mostly_below ? &view.normal : nullptr});
    }
    trees_.emplace_back();
    add_tree(seen_(rasterized_), 1);
}

}  // namespace haarfield
