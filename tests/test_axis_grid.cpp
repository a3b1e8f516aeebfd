#include "fields/occluder/axis_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/fixtures/example_meshes.h"

namespace haarfield {
namespace {

/// Returns a triangle fan around the origin in the plane y = 0.
Mesh disc(std::uint32_t corners) {
    Mesh mesh;
    mesh.positions.push_back({0, 0, 0});
    for (std::uint32_t i = 0; i < corners; ++i) {
        const double angle = 2 * M_PI * i / corners;
        mesh.positions.push_back({float(std::cos(angle)), 0, float(std::sin(angle))});
        mesh.triangles.push_back({0, 1 + (i + 1) % corners, 1 + i});
    }
    return mesh;
}

/// Returns adjacent planks that cross the plane y = 0 diagonally.
Mesh planks(std::uint32_t count) {
    Mesh mesh;
    for (std::uint32_t i = 0; i <= count; ++i) {
        const float shift = float(i) / float(count);
        mesh.positions.push_back({shift, 0, -shift});
        mesh.positions.push_back({shift + 5, 0, 5 - shift});
        if (i == 0) continue;
        const std::uint32_t v = 2 * i;
        mesh.triangles.push_back({v - 2, v - 1, v});
        mesh.triangles.push_back({v - 1, v + 1, v});
    }
    return mesh;
}

/// Returns the wall of a cylinder along y: tall, narrow triangles.
Mesh cylinder_wall(std::uint32_t corners) {
    Mesh mesh;
    for (std::uint32_t i = 0; i < corners; ++i) {
        const double angle = 2 * M_PI * i / corners;
        for (const float y : {0.0f, 3.0f})
            mesh.positions.push_back({float(std::cos(angle)), y, float(std::sin(angle))});
        const std::uint32_t v = 2 * i, w = 2 * ((i + 1) % corners);
        mesh.triangles.push_back({v, v + 1, w});
        mesh.triangles.push_back({w, v + 1, w + 1});
    }
    return mesh;
}

/// Returns triangles that all have the same bounding box.
Mesh stack(std::uint32_t count) {
    Mesh mesh;
    for (std::uint32_t i = 0; i < count; ++i) {
        const float height = float(i) / float(count);
        mesh.positions.insert(mesh.positions.end(), {{0, height, 0}, {1, height, 0}, {0, 1 - height, 1}});
        mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return mesh;
}

AxisGrid grid_of(const Mesh& mesh, std::size_t axis) {
    return axis_grid(mesh.positions, mesh.triangles, axis_frames[axis]);
}

std::size_t bytes_of(const AxisGrid& grid) {
    return 4 * (grid.first.size() + grid.triangle.size() + grid.long_triangles.triangle.size()) +
           sizeof(LongTriangles::Node) * grid.long_triangles.nodes.size();
}

std::vector<std::uint32_t> visited_at(const AxisGrid& grid, double across, double up) {
    std::vector<std::uint32_t> visited;
    grid.visit_triangles_at(across, up, [&](std::uint32_t t) { visited.push_back(t); });
    return visited;
}

/// True if the projection of a triangle, including its edges, contains a point.
bool contains(const Mesh& mesh, std::uint32_t t, const AxisFrame& frame, double across, double up) {
    double x[3], y[3];
    for (std::size_t v = 0; v < 3; ++v) {
        x[v] = double(mesh.positions[mesh.triangles[t][v]][frame.across]) - across;
        y[v] = double(mesh.positions[mesh.triangles[t][v]][frame.up]) - up;
    }
    double least = INFINITY, most = -INFINITY;
    for (std::size_t v = 0; v < 3; ++v) {
        const double side = x[v] * y[(v + 1) % 3] - x[(v + 1) % 3] * y[v];
        least = std::min(least, side);
        most = std::max(most, side);
    }
    const auto straddles = [](const double(&of)[3]) {
        return *std::ranges::min_element(of) <= 0 && *std::ranges::max_element(of) >= 0;
    };
    return (least >= 0 || most <= 0) && straddles(x) && straddles(y);
}

TEST(AxisGrid, VisitsEveryTriangleThatContainsAPointOnce) {
    std::mt19937 random(3);
    for (const Mesh& mesh : {disc(700), planks(300), cylinder_wall(500), stack(300),
                             sphere_mesh({0, 0, 0}, 1, 24), box_mesh({0, 0, 0}, {1, 1, 1}), Mesh()})
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const AxisGrid grid = grid_of(mesh, axis);
            for (int i = 0; i < 300; ++i) {
                double across = std::uniform_real_distribution(-2.0, 7.0)(random),
                       up = std::uniform_real_distribution(-2.0, 7.0)(random);
                // Every other point is a vertex or an edge's midpoint.
                if (i % 2 == 1 && !mesh.positions.empty()) {
                    const auto some = [&] { return mesh.positions[random() % mesh.positions.size()]; };
                    const Vec3f p = i % 4 == 1 ? some() : (some() + some()) * 0.5f;
                    across = double(p[axis_frames[axis].across]);
                    up = double(p[axis_frames[axis].up]);
                }
                std::vector<std::uint32_t> visited = visited_at(grid, across, up);
                std::ranges::sort(visited);
                EXPECT_EQ(std::ranges::adjacent_find(visited), visited.end()) << "twice";
                for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
                    if (!contains(mesh, t, axis_frames[axis], across, up)) continue;
                    EXPECT_TRUE(std::ranges::binary_search(visited, t))
                        << t << " of " << mesh.triangles.size() << " on axis " << axis << " at " << across
                        << ' ' << up;
                }
            }
        }
}

TEST(AxisGrid, NeedsAtMost80BytesPerTriangle) {
    for (const Mesh& mesh : {disc(20000), planks(10000), cylinder_wall(10000), stack(20000)})
        for (std::size_t axis = 0; axis < 3; ++axis)
            EXPECT_LE(bytes_of(grid_of(mesh, axis)), 80 * mesh.triangles.size()) << "axis " << axis;
}

TEST(AxisGrid, VisitsFewTrianglesOfFansPlanksAndWalls) {
    std::mt19937 random(4);
    const auto mean_visited = [&](const Mesh& mesh, std::size_t axis, float lower, float upper) {
        const AxisGrid grid = grid_of(mesh, axis);
        std::uniform_real_distribution<double> coordinate(lower, upper);
        std::size_t sum = 0;
        for (int i = 0; i < 500; ++i) sum += visited_at(grid, coordinate(random), coordinate(random)).size();
        return double(sum) / 500;
    };
    EXPECT_LT(mean_visited(disc(20000), 1, -1, 1), 60);
    EXPECT_LT(mean_visited(planks(10000), 1, 0, 5), 30);
    EXPECT_LT(mean_visited(cylinder_wall(10000), 0, 0, 1), 60);
}

}  // namespace
}  // namespace haarfield
