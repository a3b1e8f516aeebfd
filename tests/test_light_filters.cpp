#include "shading/visibility/light_filters.h"

#include <gtest/gtest.h>

#include <random>

#include "fields/base/rotation.h"
#include "shading/bake/lamp_light.h"
#include "shading/bake/renderer.h"
#include "tests/fixtures/example_meshes.h"
#include "tests/fixtures/example_scene.h"

namespace haarfield {
namespace {

constexpr Rgb green{0.5f, 0.9f, 0.6f};

/// Returns the number of surfaces of a sphere of radius 1 at the origin that a segment crosses.
int crossings(const Vec3d& from, const Vec3d& end) {
    const Vec3d way = end - from;
    const double a = way.dot(way), b = from.dot(way), c = from.dot(from) - 1, root = b * b - a * c;
    if (root <= 0) return 0;
    int count = 0;
    for (const double t : {(-b - std::sqrt(root)) / a, (-b + std::sqrt(root)) / a}) count += t > 0 && t < 1;
    return count;
}

TEST(LightFilters, PassTheProductOfAllCrossings) {
    LightFilters filters;
    const Mesh ball = sphere_mesh({0, 0, 0}, 1, 60);
    filters.add(ball.positions, ball.triangles, {green});
    filters.commit();
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(-2, 2);
    std::array<int, 3> found{};
    for (int k = 0; k < 3000; ++k) {
        const Vec3d from(uniform(random), uniform(random), uniform(random)),
            end(uniform(random), uniform(random), uniform(random));
        const Vec3d nearest =
            from + (end - from) * std::clamp(-from.dot(end - from) / (end - from).length2(), 0.0, 1.0);
        constexpr double facets = 0.01;  // Between the sphere and its mesh.
        if (std::abs(nearest.length() - 1) < facets || std::abs(from.length() - 1) < facets ||
            std::abs(end.length() - 1) < facets)
            continue;
        const int count = crossings(from, end);
        ++found[std::size_t(count)];
        const Rgb passed = filters.transmitted(Vec3f(from), Vec3f(end));
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(passed[c], std::pow(green[c], count), 1e-6) << from << end;
    }
    for (const int count : found) EXPECT_GT(count, 100);
}

TEST(LightFilters, AbsorbInsideTheirMeshes) {
    LightFilters filters;
    const Mesh ball = sphere_mesh({0, 0, 0}, 1, 100), box = box_mesh({2, -1, -1}, {3, 1, 1}, 2);
    filters.add(ball.positions, ball.triangles, {green}, {1, 0.5f, 0});
    filters.add(box.positions, box.triangles, {Rgb(1.0f)}, {0, 0, 2});
    filters.commit();
    // Through the middle, beside it, through both objects, and from the inside.
    const Rgb whole = filters.transmitted({-5, 0, 0.001f}, {1.5f, 0, 0.001f});
    for (int c = 0; c < 3; ++c) {
        const float k = std::array{1.0f, 0.5f, 0.0f}[std::size_t(c)];
        EXPECT_NEAR(whole[c], green[c] * green[c] * std::exp(-2 * k), 1e-3);
        EXPECT_NEAR(filters.transmitted({-5, 0.6f, 0}, {1.5f, 0.6f, 0})[c],
                    green[c] * green[c] * std::exp(-1.6 * k), 1e-3);
        const float behind = c == 2 ? std::exp(-2.0f) : 1.0f;
        EXPECT_NEAR(filters.transmitted({-5, 0, 0.001f}, {9, 0, 0.001f})[c], whole[c] * behind, 1e-3);
    }
}

TEST(LightFilters, AbsorbFromTheLastCrossingAsPovrayDoes) {
    LightFilters filters;
    const Mesh glass = box_mesh({-2, -1, -1}, {2, 1, 1}),
               wine = box_mesh({-1, -0.5f, -0.5f}, {1, 0.5f, 0.5f});
    filters.add(glass.positions, glass.triangles, {Rgb(1.0f)}, {0.1f, 0.2f, 0});
    filters.add(wine.positions, wine.triangles, {Rgb(0.5f)}, {1, 0, 0.3f});
    filters.commit();
    const Rgb passed = filters.transmitted({-5, 0.1f, 0.2f}, {5, 0.1f, 0.2f});
    const std::array glass_ways{0.1f, 0.2f, 0.0f}, wine_ways{2.0f, 0.0f, 0.6f};
    for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(passed[int(c)], 0.25f * std::exp(-glass_ways[c] - wine_ways[c]), 1e-4) << c;
}

TEST(LightFilters, TrianglesHaveColours) {
    LightFilters filters;
    const Mesh pane = square_mesh(2, 1, 4);
    std::vector<Rgb> colours;
    for (const auto& [a, b, c] : pane.triangles) {
        const float x = pane.positions[a].x + pane.positions[b].x + pane.positions[c].x;
        colours.push_back(x < 0 ? green : Rgb(0.25f));
    }
    filters.add(pane.positions, pane.triangles, colours);
    filters.commit();
    EXPECT_EQ(filters.transmitted({-0.3f, 0, 0.1f}, {-0.3f, 2, 0.1f}), green);
    EXPECT_EQ(filters.transmitted({0.3f, 0, 0.1f}, {0.3f, 2, 0.1f}), Rgb(0.25f));
}

TEST(LightFilters, CountAnEdgeOfTwoTrianglesOnce) {
    LightFilters filters;
    const Mesh pane = square_mesh(2, 1, 4);
    filters.add(pane.positions, pane.triangles, {green});
    filters.commit();
    for (int k = 0; k < 200; ++k) {
        // Along the diagonals of the cells, from near and far.
        const float x = -0.9f + 0.009f * float(k), up = k % 2 ? 1.01f : 300.0f;
        const Rgb passed = filters.transmitted({x, 0.2f, x}, {x, up, x});
        EXPECT_EQ(passed, green) << x;
        EXPECT_EQ(filters.transmitted({x, 0.2f, x}, {x, 0.9f, x}), Rgb(1.0f)) << "it ends before the pane";
    }
    EXPECT_EQ(LightFilters().transmitted({0, 0, 0}, {0, 9, 0}), Rgb(1.0f));
}

TEST(LightFilters, TintTheLightOfLamps) {
    ExampleScene example;
    example.add_entity(square_mesh(4, 0, 8), matte(0.5f));
    example.scene.instances.push_back({0, {}});
    Lamp lamp;
    lamp.position = {0, 3, 0};
    lamp.colour = {2, 2, 2};
    example.scene.lamps = {lamp};
    example.scene.environment = environment([](const Vec3d&) { return 0.0; });
    RenderSettings settings;
    settings.face_size = ExampleScene::size;
    const SceneColours without = total(*scene_radiance(example.scene, settings));
    auto filters = std::make_shared<LightFilters>();
    const Mesh pane = square_mesh(1, 1);  // Its shadow is a square with edges of 1.5.
    filters->add(pane.positions, pane.triangles, {green});
    filters->commit();
    example.scene.filters = filters;
    const SceneColours with = total(*scene_radiance(example.scene, settings));
    const Mesh& floor = *example.scene.entities[0].mesh;
    std::array<int, 2> compared{};
    for (std::size_t v = 0; v < with[0].size(); ++v) {
        const Vec3f& at = floor.positions[v];
        const float aside = std::max(std::abs(at.x), std::abs(at.z));
        if (std::abs(aside - 0.75f) < 0.01f) continue;
        const bool is_behind = aside < 0.75f;
        ++compared[is_behind];
        ASSERT_GT(without[0][v].x, 0);
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(with[0][v][c] / without[0][v][c], is_behind ? green[c] : 1.0f, 1e-5) << at;
    }
    EXPECT_GT(compared[0], 20);
    EXPECT_GT(compared[1], 5);
}

}  // namespace
}  // namespace haarfield
