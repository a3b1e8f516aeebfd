#include "shading/visibility/vertex_visibility.h"

#include <algorithm>
#include <tuple>

namespace haarfield {

void VertexVisibility::add_tree(const WideCubemap<std::uint8_t>& tree, float weight) {
    parts_.push_back({&tree, weight});
    const std::size_t count = trees_.back().parts.size() + 1;
    trees_.back().parts = {parts_.data() + parts_.size() - count, count};
}

void VertexVisibility::clear(const ShadingPoint& point) {
    trees_.clear();
    parts_.clear();
    cones_.clear();
    candidates_.clear();
    rasterized_.clear();
    distant_.clear();
    made_.clear();
    around_ = groups_ ? groups_->around(point.outside)
                      : DistantGroups::Surroundings{nullptr, 0, geometry_.grid.near(point.outside)};
    parts_.reserve(3 + 8 * around_.near.size());  // Keeps spans of its elements valid.
}

bool VertexVisibility::look(std::size_t instance, std::uint32_t vertex, const ShadingPoint& point) {
    const ShadedInstance& placed = scene_.instances[instance];
    const WideVisibility& field = geometry_.entities[placed.entity].visibility;
    if (!is_identity(placed.placement.rotate) || !field.has_local())
        return look(instance, surface_point(scene_.entities[placed.entity], vertex), point);
    clear(point);
    trees_.emplace_back();
    add_tree(field.local(vertex), 1);
    return add_occlusion_by_others(instance, point);
}

bool VertexVisibility::look(std::size_t instance, const SurfacePoint& surface, const ShadingPoint& point) {
    clear(point);
    rasterized_.push_back(own_view(scene_, instance, surface.sample, point));
    return add_occlusion_by_others(instance, point);
}

bool VertexVisibility::add_occlusion_by_others(std::size_t instance, const ShadingPoint& point) {
    for (const std::uint32_t i : around_.near)
        if (i != instance && i != without_ && !add_occlusion_by(i, point)) return false;
    choose_candidates(point);
    if (around_.distant) add_made(*around_.distant, around_.number);
    if (rasterized_.empty() && distant_.empty()) return true;
    const std::span<std::uint8_t> texels = seen_.texels(rasterized_);
    for (const std::uint32_t i : distant_)
        geometry_.impostors[scene_.instances[i].entity]->hide(scene_.instances[i].placement, point.outside,
                                                              texels);
    seen_.tree();
    add_made(seen_.last(), 0);
    return true;
}

void VertexVisibility::add_made(const TexelTree& tree, std::uint64_t number) {
    made_.push_back({&tree, number});
    trees_.emplace_back();
    add_tree(tree.faces, 1);
}

bool VertexVisibility::add_occlusion_by(std::uint32_t instance, const ShadingPoint& point) {
    const auto [visibility, share] = occlusion_of(scene_, geometry_, instance, point);
    if (visibility == OcclusionKind::open) return true;
    if (visibility == OcclusionKind::distant) {
        add_impostor(instance, point);
        return true;
    }
    const ShadedInstance& other = scene_.instances[instance];
    const ShadingGeometry::Instance& seen = geometry_.instances[instance];
    const bool by_cones = !seen.polygons.empty();
    if (visibility == OcclusionKind::sampled || (!rasterizes_ && !by_cones && !seen.is_turned)) {
        look_up(other, point);
        return true;
    }
    const EntityOcclusion& occlusion = *scene_.entities[other.entity].occlusion;
    if (occlusion.coarse().one_sided() > 0 &&
        occlusion.in_coarse()(other.placement.point_to_object(point.outside)))
        return false;
    if (by_cones)
        add_cones(seen.polygons, other.placement.point_to_turned(point.outside), cones_);
    else
        candidates_.push_back({share, instance});
    return true;
}

void VertexVisibility::add_impostor(std::uint32_t instance, const ShadingPoint& point) {
    if (geometry_.impostors[scene_.instances[instance].entity])
        distant_.push_back(instance);
    else
        look_up(scene_.instances[instance], point);
}

void VertexVisibility::look_up(const ShadedInstance& other, const ShadingPoint& point) {
    const WideVisibility& visibility = geometry_.entities[other.entity].visibility;
    const auto [planar, samples] = field_lookup(*scene_.entities[other.entity].field, other, point);
    if (samples.count == 0) return;
    trees_.emplace_back().constant = samples.open;
    for (std::size_t k = 0; k < std::size_t(samples.count); ++k)
        add_tree(planar ? visibility.planar(samples.sample[k]) : visibility.spherical(samples.sample[k]),
                 samples.weight[k]);
}

void VertexVisibility::choose_candidates(const ShadingPoint& point) {
    if (candidates_.size() > geometry_.most_rasterized) {
        const auto end = candidates_.begin() + std::ptrdiff_t(geometry_.most_rasterized);
        std::nth_element(candidates_.begin(), end, candidates_.end(),
                         [](const Candidate& a, const Candidate& b) {
                             return std::tie(a.distance, a.instance) < std::tie(b.distance, b.instance);
                         });
        // A fixed order of factors: nth_element leaves it unspecified.
        std::sort(end, candidates_.end(),
                  [](const Candidate& a, const Candidate& b) { return a.instance < b.instance; });
        for (auto farther = end; farther != candidates_.end(); ++farther)
            if (geometry_.instances[farther->instance].is_turned)
                add_impostor(farther->instance, point);
            else
                look_up(scene_.instances[farther->instance], point);
        candidates_.erase(end, candidates_.end());
    }
    for (const Candidate& candidate : candidates_) rasterize(candidate.instance, point);
}

void VertexVisibility::rasterize(std::uint32_t instance, const ShadingPoint& point) {
    OccluderView view = view_of(scene_, instance, point);
    view.occluder = &occluder_for(scene_, geometry_, instance, point);
    // The test for triangles below the horizon has a cost.
    if ((geometry_.instances[instance].middle - point.outside).dot(point.brdf.normal) < 0)
        view.horizon = &point.brdf.normal;
    rasterized_.push_back(view);
}

}  // namespace haarfield
