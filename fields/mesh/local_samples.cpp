#include "fields/mesh/local_samples.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

namespace haarfield {
namespace {

/// Of each vertex, the middle of its triangles that are not buried in another piece.
struct VisibleMiddles {
    std::vector<Vec3f> sum;
    std::vector<std::uint32_t> count;
};

VisibleMiddles visible_middles(const Mesh& mesh, const LocalSampler& sampler, const std::stop_token& stop) {
    struct Middle {
        Vec3f position;
        bool buried;
    };
    std::vector<Middle> of_triangle(mesh.triangles.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, of_triangle.size(), 64), [&](const auto& range) {
        for (std::size_t t = range.begin(); t != range.end() && !stop.stop_requested(); ++t) {
            const Vec3f &a = mesh.positions[mesh.triangles[t][0]], &b = mesh.positions[mesh.triangles[t][1]],
                        &c = mesh.positions[mesh.triangles[t][2]];
            of_triangle[t] = {(a + b + c) / 3.0f, sampler.is_buried(a, b, c)};
        }
    });
    VisibleMiddles middles{std::vector<Vec3f>(mesh.positions.size(), Vec3f(0.0f)),
                           std::vector<std::uint32_t>(mesh.positions.size(), 0)};
    for (std::size_t t = 0; t < of_triangle.size(); ++t) {
        if (of_triangle[t].buried) continue;
        for (const std::uint32_t v : mesh.triangles[t]) {
            middles.sum[v] += of_triangle[t].position;
            ++middles.count[v];
        }
    }
    return middles;
}

}  // namespace

LocalSampler::LocalSampler(const Occluder& original, const InsideTest& in_original, const Occluder& own)
    : in_original_(in_original), radius_(own.bounds().radius()) {
    // One-sided pieces are open from below, so that only two-sided ones can hide a vertex under their bulges.
    if (own.one_sided() < own.triangles().size() && own.triangles().size() != original.triangles().size())
        rays_ = std::make_unique<SurfaceRays>(own.positions(), own.triangles());
}

bool LocalSampler::is_buried(const Vec3f& a, const Vec3f& b, const Vec3f& c) const {
    const Vec3f normal = (b - a).cross(c - a).normalized();
    return in_original_((a + b + c) / 3.0f + normal * (radius_ * surface_offset));
}

Vec3f LocalSampler::sample(const Vec3f& position, const Vec3f& normal, const Vec3f& middle) const {
    constexpr float inwards = 0.05f;  // of the way to the middle of the triangles
    constexpr float bulge_limit =
        0.02f;  // beyond it, what lies over a vertex is no error of simplification [radii]
    const float offset = radius_ * surface_offset;
    const Vec3f towards = middle - position;
    Vec3f point = position;
    point += (towards - normal * normal.dot(towards)) * inwards + normal * offset;
    if (!rays_) return point;
    for (int layer = 0; layer < 3; ++layer) {
        const float bulge = rays_->distance_to_back(point, normal, radius_ * bulge_limit);
        if (bulge == 0) break;
        point += normal * (bulge + offset);
    }
    return point;
}

LocalSamples local_samples(const Mesh& fine, const LocalSampler& sampler, std::stop_token stop) {
    const VisibleMiddles middles = visible_middles(fine, sampler, stop);
    LocalSamples samples;
    samples.points = fine.positions;
    samples.buried.assign(fine.positions.size(), 0);
    for (std::size_t v = 0; v < fine.positions.size() && !stop.stop_requested(); ++v)
        if (middles.count[v] == 0)
            samples.buried[v] = 1;
        else
            samples.points[v] = sampler.sample(fine.positions[v], fine.normals[v],
                                               middles.sum[v] / static_cast<float>(middles.count[v]));
    return samples;
}

}  // namespace haarfield
