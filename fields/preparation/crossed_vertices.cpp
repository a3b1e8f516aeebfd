#include "fields/preparation/crossed_vertices.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "fields/base/embree_rays.h"
#include "fields/preparation/local_samples.h"

namespace haarfield {
namespace {

constexpr double parallel = 0.999;  // cosine of the angle between planes
constexpr double steep = 0.9;       // cosine; triangles at smaller angles to the surface are ignored
constexpr std::size_t most_planes = 16;

/// A triangle in the plane normal . p = normal . corners[0].
struct Facet {
    std::array<Vec3d, 3> corners;
    Vec3d normal;  ///< Unit length; 0 for zero area.
};

Facet facet(const Mesh& mesh, std::size_t triangle) {
    const auto& [i, j, k] = mesh.triangles[triangle];
    const Vec3d a(mesh.positions[i]), b(mesh.positions[j]), c(mesh.positions[k]);
    return {{a, b, c}, (b - a).cross(c - a).normalized()};
}

Vec3d nearest_of_segment(const Vec3d& point, const Vec3d& a, const Vec3d& b) {
    const Vec3d along = b - a;
    return a + along * std::clamp((point - a).dot(along) / along.length2(), 0.0, 1.0);
}

double distance2(const Vec3d& point, const Facet& facet) {
    bool is_over = true;
    double least = INFINITY;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3d &a = facet.corners[k], &b = facet.corners[(k + 1) % 3];
        is_over &= facet.normal.cross(b - a).dot(point - a) >= 0;
        least = std::min(least, (point - nearest_of_segment(point, a, b)).length2());
    }
    const double height = facet.normal.dot(point - facet.corners[0]);
    return is_over ? height * height : least;
}

/// Finds the triangles of a mesh that pass through given points.
class PassingTriangles {
public:
    explicit PassingTriangles(const Mesh& mesh)
        : mesh_(mesh),
          reach_(double(mesh_bounds(mesh).radius() * surface_offset)),
          scene_(rtcNewScene(device_.get()), &rtcReleaseScene) {
        const std::shared_ptr<RTCGeometryTy> geometry = device_.triangles(mesh.positions, mesh.triangles);
        rtcCommitGeometry(geometry.get());
        rtcAttachGeometry(scene_.get(), geometry.get());
        device_.commit(scene_.get());
    }

    /// Returns, in ascending order, those that rise from the front of a surface with this normal.
    std::vector<std::uint32_t> operator()(const Vec3f& point, const Vec3f& normal) const {
        std::vector<std::uint32_t> near;
        RTCPointQuery query{point.x, point.y, point.z, 0, static_cast<float>(2 * reach_)};
        RTCPointQueryContext context;
        rtcInitPointQueryContext(&context);
        rtcPointQuery(
            scene_.get(), &query, &context,
            [](RTCPointQueryFunctionArguments* found) {
                static_cast<std::vector<std::uint32_t>*>(found->userPtr)->push_back(found->primID);
                return false;  // the query keeps its radius
            },
            &near);
        std::erase_if(near, [&](std::uint32_t t) { return !passes(t, Vec3d(point), Vec3d(normal)); });
        std::ranges::sort(near);
        return near;
    }

private:
    bool passes(std::uint32_t triangle, const Vec3d& point, const Vec3d& normal) const {
        const Facet found = facet(mesh_, triangle);
        if (found.normal == Vec3d(0, 0, 0) || std::abs(found.normal.dot(normal)) > steep) return false;
        const bool rises = std::ranges::any_of(
            found.corners, [&](const Vec3d& corner) { return (corner - point).dot(normal) > 10 * reach_; });
        return rises && distance2(point, found) <= reach_ * reach_;
    }

    const Mesh& mesh_;
    const double reach_;
    EmbreeDevice device_;
    std::unique_ptr<RTCSceneTy, void (*)(RTCSceneTy*)> scene_;
};

/// Returns planes through a vertex that are parallel neither to its own triangles nor to each other.
std::vector<Vec3d> dividing_planes(const Mesh& original, std::span<const std::uint32_t> passing,
                                   std::span<const Facet> own) {
    std::vector<Vec3d> planes;
    for (const std::uint32_t t : passing) {
        const Vec3d normal = facet(original, t).normal;
        const auto is_parallel = [&](const Vec3d& other) { return std::abs(other.dot(normal)) > parallel; };
        if (planes.size() < most_planes && std::ranges::none_of(own, is_parallel, &Facet::normal) &&
            std::ranges::none_of(planes, is_parallel))
            planes.push_back(normal);
    }
    return planes;
}

/// Returns, as bits, on which sides of planes through a point a triangle lies.
std::uint32_t sides_of(const Facet& triangle, const Vec3d& point, std::span<const Vec3d> planes) {
    const Vec3d middle = (triangle.corners[0] + triangle.corners[1] + triangle.corners[2]) / 3.0;
    std::uint32_t sides = 0;
    for (std::size_t k = 0; k < planes.size(); ++k)
        sides |= std::uint32_t((middle - point).dot(planes[k]) > 0) << k;
    return sides;
}

}  // namespace

std::size_t split_crossed_vertices(Mesh& fine, const Mesh& original) {
    const PassingTriangles passing_triangles(original);
    const std::size_t before = fine.positions.size();
    std::vector<std::uint8_t> is_crossed(before);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, before, 256), [&](const auto& range) {
        for (std::size_t v = range.begin(); v != range.end(); ++v)
            is_crossed[v] = !passing_triangles(fine.positions[v], fine.normals[v]).empty();
    });
    std::map<std::uint32_t, std::vector<std::uint32_t>> triangles_of;
    for (std::size_t t = 0; t < fine.triangles.size(); ++t)
        for (const std::uint32_t v : fine.triangles[t])
            if (is_crossed[v]) triangles_of[v].push_back(static_cast<std::uint32_t>(t));
    for (const auto& [v, triangles] : triangles_of) {
        std::vector<Facet> own;
        for (const std::uint32_t t : triangles) own.push_back(facet(fine, t));
        const std::vector<Vec3d> planes =
            dividing_planes(original, passing_triangles(fine.positions[v], fine.normals[v]), own);
        std::map<std::uint32_t, std::uint32_t> vertex_of_sides;
        for (std::size_t k = 0; k < own.size(); ++k) {
            const std::uint32_t sides = sides_of(own[k], Vec3d(fine.positions[v]), planes);
            const auto found = vertex_of_sides.find(sides);
            const std::uint32_t vertex = found != vertex_of_sides.end() ? found->second
                                         : vertex_of_sides.empty()      ? v
                                                                        : fine.copy_vertex(v);
            vertex_of_sides[sides] = vertex;
            std::ranges::replace(fine.triangles[triangles[k]], v, vertex);
        }
    }
    return fine.positions.size() - before;
}

}  // namespace haarfield
