#include "fields/rasterizer/visible_contour.h"

#include <gtest/gtest.h>

#include <map>
#include <string>

#include "fields/mesh/edge_uses.h"
#include "tests/fixtures/example_meshes.h"

namespace haarfield {
namespace {

/// By the vertices of an edge, lower index first: layers on its left, in the direction of the higher index,
/// minus those on its right.
using Weights = std::map<std::pair<std::uint32_t, std::uint32_t>, int>;

/// Computes the weights from the facing of every triangle.
Weights wanted_weights(const Occluder& occluder, const ViewedOccluder& viewed) {
    Weights weights;
    for (const EdgeUse& use : sorted_edge_uses(occluder.triangles())) {
        const int counts = facing(occluder, viewed, use.triangle);
        weights[{use.low, use.high}] += use.forward ? counts : -counts;
    }
    std::erase_if(weights, [](const auto& entry) { return entry.second == 0; });
    return weights;
}

Weights found_weights(const Occluder& occluder, const VisibleContour& contour) {
    Weights weights;
    for (std::size_t i = 0; i < contour.count; ++i) {
        const std::uint32_t number = contour.numbers.data()[i], lane = number % OccluderEdges::cluster_size;
        const OccluderEdges::Cluster& cluster =
            occluder.edges().clusters[number / OccluderEdges::cluster_size];
        const std::uint32_t from = cluster.vertices[0][lane], to = cluster.vertices[1][lane];
        const int weight = static_cast<int>(contour.weights.data()[i]);
        weights[{std::min(from, to), std::max(from, to)}] += from < to ? weight : -weight;
    }
    std::erase_if(weights, [](const auto& entry) { return entry.second == 0; });
    return weights;
}

/// Returns points in all directions, near and far, including lattice points of boxes.
std::vector<Vec3f> view_points() {
    std::vector<Vec3f> points;
    std::uint32_t seed = 11;
    const auto uniform = [&] {
        seed = seed * 1664525u + 1013904223u;
        return static_cast<float>(seed >> 8) / static_cast<float>(1u << 23) - 1;
    };
    for (int i = 0; i < 200; ++i) {
        const float distance = i % 4 == 0 ? 20.0f : 1.7f;
        points.push_back(Vec3f(uniform(), uniform(), uniform()) * distance);
    }
    for (int i = 0; i < 27; ++i) points.push_back(Vec3f(float(i % 3), float(i / 3 % 3), float(i / 9)) * 0.5f);
    return points;
}

TEST(VisibleContour, HasTheEdgesAtWhichTrianglesCountDifferently) {
    const Mesh box = box_mesh({-1, -1, -1}, {1, 1, 1}, 4), sphere = sphere_mesh({0.1f, 0, 0}, 1.2f, 24),
               sheet = square_mesh(3, 0.25f, 12), tile = square_mesh(1, 1.1f);
    const std::map<std::string, Mesh> meshes{
        {"box", box},
        {"sphere and sheet", joined_meshes(sphere, sheet)},
        {"box, sphere, sheet and tile",
         joined_meshes(joined_meshes(box, sphere), joined_meshes(sheet, tile))}};
    std::size_t edges = 0, cut = 0;
    VisibleContour contour;
    for (const auto& [name, mesh] : meshes)
        for (const bool two_sided : {false, true}) {
            OccluderTriangles triangles = make_occluder(mesh).source();
            if (two_sided) triangles.one_sided /= 2;  // within a piece
            const Occluder occluder(triangles);
            for (const Vec3f& point : view_points())
                for (const bool with_horizon : {false, true}) {
                    const Vec3f up = Vec3f(point.y + 0.1f, -point.z, point.x).normalized();
                    const ViewedOccluder viewed = look_at(occluder, point, with_horizon ? &up : nullptr);
                    find_contour(occluder, viewed, contour);
                    EXPECT_EQ(found_weights(occluder, contour), wanted_weights(occluder, viewed))
                        << name << " from " << point << (with_horizon ? " with a horizon" : "");
                    edges += contour.count;
                    cut += contour.cut_count;
                }
        }
    EXPECT_GT(edges, 100000u);
    EXPECT_GT(cut, 10000u);
}

TEST(VisibleContour, VisitsFewOfTheEdges) {
    const Occluder occluder = make_occluder(sphere_mesh({0, 0, 0}, 1, 96));
    VisibleContour contour;
    for (const Vec3f& point : {Vec3f(3, 1, 2), Vec3f(-1, -2, 0.3f), Vec3f(0.1f, 9, -0.4f)}) {
        const Vec3f up = point.normalized();
        find_contour(occluder, look_at(occluder, point, nullptr), contour);
        EXPECT_GT(contour.count, 90u);
        EXPECT_LT(contour.open_count, occluder.edges().clusters.size() / 8) << point;
        // All of it is below.
        find_contour(occluder, look_at(occluder, point, &up), contour);
        EXPECT_EQ(contour.open_count + contour.cut_count, 0u) << point;
    }
}

}  // namespace
}  // namespace haarfield
