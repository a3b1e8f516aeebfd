#include "fields/preparation/local_samples.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

namespace haarfield {
namespace {

constexpr float inwards = 0.05f;  // fraction of the way to the centroids

/// Indexed by vertex.
std::vector<VisibleMiddles> visible_middles(const Mesh& mesh, const LocalSampler& sampler,
                                            const std::stop_token& stop) {
    std::vector<std::optional<Vec3f>> of_triangle(mesh.triangles.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, of_triangle.size(), 64), [&](const auto& range) {
        for (std::size_t t = range.begin(); t != range.end() && !stop.stop_requested(); ++t) {
            const auto& [a, b, c] = mesh.triangles[t];
            of_triangle[t] = sampler.visible_middle(mesh.positions[a], mesh.positions[b], mesh.positions[c]);
        }
    });
    std::vector<VisibleMiddles> middles(mesh.positions.size());
    for (std::size_t t = 0; t < of_triangle.size(); ++t)
        if (of_triangle[t])
            for (const std::uint32_t v : mesh.triangles[t])
                middles[v].add(mesh.positions[v], *of_triangle[t]);
    return middles;
}

}  // namespace

void VisibleMiddles::add(const Vec3f& position, const Vec3f& middle) {
    if (count == 0 || (middle - position).length2() < (nearest - position).length2()) nearest = middle;
    sum += middle;
    ++count;
}

LocalSampler::LocalSampler(const Occluder& original, const InsideTest& in_original, const Occluder& own)
    : in_original_(in_original), radius_(own.bounds().radius()) {
    // The inside of one-sided pieces does not block, so only two-sided ones can cover a vertex with a bulge.
    if (own.one_sided() < own.triangles().size() && own.triangles().size() != original.triangles().size())
        rays_ = std::make_unique<SurfaceRays>(own.positions(), own.triangles());
}

std::optional<Vec3f> LocalSampler::visible_middle(const Vec3f& a, const Vec3f& b, const Vec3f& c) const {
    const Vec3f normal = (b - a).cross(c - a).normalized();
    const Vec3f middle = (a + b + c) / 3.0f + normal * (radius_ * surface_offset);
    if (in_original_(middle)) return std::nullopt;
    return middle;
}

/// Moves a point inside another piece towards a visible one: to the boundary, and a twentieth of the
/// remaining way beyond it.
Vec3f LocalSampler::outside(const Vec3f& point, const Vec3f& visible) const {
    if (!in_original_(point)) return point;
    float inside = 0, out = 1;  // fractions of the way
    for (int step = 0; step < 6; ++step) {
        const float middle = (inside + out) / 2;
        (in_original_(point + (visible - point) * middle) ? inside : out) = middle;
    }
    const float beyond = out + (1 - out) * inwards;
    const Vec3f moved = point + (visible - point) * beyond;
    return in_original_(moved) ? visible : moved;
}

Vec3f LocalSampler::sample(const Vec3f& position, const Vec3f& normal, const VisibleMiddles& middles) const {
    constexpr float bulge_limit = 0.02f;  // larger bulges do not result from simplification [radii]
    const float offset = radius_ * surface_offset;
    const Vec3f towards = middles.sum / static_cast<float>(middles.count) - position;
    Vec3f point = position;
    point += (towards - normal * std::min(0.0f, normal.dot(towards))) * inwards + normal * offset;
    point = outside(point, middles.nearest);
    if (!rays_) return point;
    for (int layer = 0; layer < 3; ++layer) {
        const float bulge = rays_->distance_to_back(point, normal, radius_ * bulge_limit);
        if (bulge == 0) break;
        point += normal * (bulge + offset);
    }
    return point;
}

LocalSamples local_samples(const Mesh& fine, const LocalSampler& sampler, std::stop_token stop) {
    const std::vector<VisibleMiddles> middles = visible_middles(fine, sampler, stop);
    LocalSamples samples;
    samples.points = fine.positions;
    samples.buried.assign(fine.positions.size(), 0);
    tbb::parallel_for(std::size_t(0), fine.positions.size(), [&](std::size_t v) {
        if (stop.stop_requested()) return;
        if (middles[v].count == 0)
            samples.buried[v] = 1;
        else
            samples.points[v] = sampler.sample(fine.positions[v], fine.normals[v], middles[v]);
    });
    return samples;
}

}  // namespace haarfield
