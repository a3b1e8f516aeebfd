#include "shading/bake/renderer.h"

#include <gtest/gtest.h>

#include "shading/scene/shared_shading.h"
#include "shading/visibility/buried_fill.h"
#include "tests/fixtures/example_scene.h"
#include "tests/fixtures/with_threads.h"

namespace haarfield {
namespace {

TEST(Renderer, FurnaceGivesTheAlbedo) {
    ExampleScene example;
    example.scene.instances.push_back(
        {example.add_entity(sphere_mesh({0, 0, 0}, 1, 12), matte(0.6f)), {{3, 1, 2}, 2}});
    example.scene.environment = environment([](const Vec3d&) { return 1.0; });
    for (const auto& radiance : {example.radiance(), example.dense()})
        for (const Rgb& r : radiance[0])
            for (int channel = 0; channel < 3; ++channel) EXPECT_NEAR(r[channel], 0.6, 0.003);
}

TEST(Renderer, WhitePhongReflectsAllOfAUniformEnvironmentAtNormalIncidence) {
    for (const float shininess : {10.0f, 60.0f, 300.0f}) {
        ExampleScene example;
        example.scene.instances.push_back(
            {example.add_entity(square_mesh(0.01f, 0), glossy(shininess, LobeConvention::physical)), {}});
        example.scene.environment = environment([](const Vec3d&) { return 1.0; });
        example.scene.eye = {0, 100, 0};
        EXPECT_NEAR(example.dense()[0][0].x, 1, 0.01) << shininess;
        EXPECT_NEAR(example.radiance()[0][0].x, 1, 0.03) << shininess;
    }
}

TEST(Renderer, PovraysSpecularTermHasTheClosedFormUnderAUniformEnvironment) {
    // 1/pi int max(0,R.w)^n over the hemisphere = 2 / (n+1) at normal incidence.
    for (const float shininess : {10.0f, 60.0f}) {
        ExampleScene example;
        example.scene.instances.push_back(
            {example.add_entity(square_mesh(0.01f, 0), glossy(shininess, LobeConvention::povray)), {}});
        example.scene.environment = environment([](const Vec3d&) { return 1.0; });
        example.scene.eye = {0, 100, 0};
        for (const auto& radiance : {example.radiance(), example.dense()})
            EXPECT_NEAR(radiance[0][0].x * (shininess + 1) / 2, 1, 0.015) << shininess;
    }
}

TEST(Renderer, SpecularLobesEndAtTheHorizon) {
    // At grazing view, half of the lobe about the mirror direction is below the surface.
    ExampleScene example;
    example.scene.instances.push_back(
        {example.add_entity(square_mesh(0.01f, 0), glossy(20, LobeConvention::povray)), {}});
    example.scene.environment = environment([](const Vec3d&) { return 1.0; });
    example.scene.eye = {1000, 0.001f, 0};
    for (const auto& radiance : {example.radiance(), example.dense()})
        EXPECT_NEAR(radiance[0][0].x * 21, 1, 0.03);
}

TEST(Renderer, SunLightsByTheCosine) {
    const Vec3d sun = Vec3d(0.3, 0.8, -0.4).normalized();
    ExampleScene example;
    example.scene.instances.push_back({example.add_entity(square_mesh(1, 0), matte(0.5f)), {}});
    double x = 0, y = 0;
    lat_long_point(sun, x, y);
    LatLongImage image = environment([](const Vec3d&) { return 0.0; }, 512);
    const int column = int(x * 512), row = int(y * 256);
    image.pixels[std::size_t(row) * 512 + std::size_t(column)] = Rgb(1000, 500, 250);
    example.scene.environment = image;
    const Vec3d centre = lat_long_direction((column + 0.5) / 512, (row + 0.5) / 256);
    const double irradiance = 1000 * lat_long_pixel_solid_angle(row, 512, 256) * centre.y;
    for (const auto& radiance : {example.radiance(), example.dense()}) {
        EXPECT_NEAR(radiance[0][0].x / (0.5 / pi * irradiance), 1, 0.02);
        EXPECT_NEAR(radiance[0][0].y / radiance[0][0].x, 0.5, 1e-3);
        EXPECT_NEAR(radiance[0][0].z / radiance[0][0].x, 0.25, 1e-3);
    }
}

TEST(Renderer, LightComesFromWhereTheEnvironmentHasIt) {
    // One bright half space at a time: the box's side that faces it is fully lit, the opposite one not at
    // all.
    const Mesh box = box_mesh({-1, -1, -1}, {1, 1, 1});
    for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {1.0, -1.0}) {
            ExampleScene example;
            example.scene.instances.push_back({example.add_entity(box, matte(0.5f)), {}});
            example.scene.environment =
                environment([&](const Vec3d& d) { return d[axis] * sign > 0 ? 1.0 : 0.0; });
            const auto radiance = example.radiance()[0];
            for (std::size_t v = 0; v < radiance.size(); ++v) {
                const double facing = box.normals[v][axis] * sign;
                EXPECT_NEAR(radiance[v].x,
                            facing > 0.5    ? 0.5
                            : facing < -0.5 ? 0.0
                                            : 0.25,
                            0.01)
                    << axis << " " << sign;
            }
        }
}

TEST(Renderer, ASphereOverheadBlocksItsFormFactor) {
    // The unoccluded irradiance is pi. A sphere of radius r at height h straight above blocks pi (r/h)^2.
    ExampleScene example;
    const auto floor = example.add_entity(square_mesh(0.001f, 0), matte(1));
    const auto sphere = example.add_entity(sphere_mesh({0, 0, 0}, 1, 40), matte(0.5f), 6, 6000);
    example.scene.environment = environment([](const Vec3d&) { return 1.0; });
    for (const float height : {1.5f, 2.0f, 4.0f}) {
        example.scene.instances = {{floor, {}}, {sphere, {{0, height, 0}, 1}}};
        const double wanted = 1 - 1 / (double(height) * height);
        EXPECT_NEAR(example.dense()[0][0].x, wanted, 0.01) << height;
        EXPECT_NEAR(example.radiance()[0][0].x, wanted, 0.03) << height;
        // Scale and translation of the whole scene change nothing.
        example.scene.instances = {{floor, {{5, 6, 7}, 3}}, {sphere, {{5, 6 + 3 * height, 7}, 3}}};
        EXPECT_NEAR(example.radiance()[0][0].x, wanted, 0.03) << height;
    }
}

TEST(Renderer, ALargeWallBlocksHalf) {
    ExampleScene example;
    const auto floor = example.add_entity(square_mesh(0.001f, 0), matte(1));
    const auto wall = example.add_entity(box_mesh({0.1f, 0, -300}, {0.2f, 300, 300}), matte(0.5f));
    example.scene.instances = {{floor, {}}, {wall, {}}};
    example.scene.environment = environment([](const Vec3d&) { return 1.0; });
    EXPECT_NEAR(example.radiance()[0][0].x, 0.5, 0.02);
    EXPECT_NEAR(example.dense()[0][0].x, 0.5, 0.02);
}

TEST(Renderer, NoLightFromBelowPassesTheFloor) {
    ExampleScene example;
    const auto floor = example.add_entity(square_mesh(400, 0, 2), matte(1));
    const auto box = example.add_entity(box_mesh({-0.5f, 0, -0.5f}, {0.5f, 1, 0.5f}, 4), matte(1));
    example.scene.instances = {{floor, {}}, {box, {}}};
    example.scene.environment = environment([](const Vec3d& d) { return d.y < -0.02 ? 1.0 : 0.0; });
    for (const auto& radiance : {example.radiance(), example.dense()}) {
        const Mesh& mesh = *example.scene.entities[box].mesh;
        for (std::size_t v = 0; v < radiance[1].size(); ++v)
            if (mesh.normals[v].y > -0.5f) {
                EXPECT_NEAR(radiance[1][v].x, 0, 0.02) << mesh.positions[v];
            }
    }
}

/// A small furnished scene under an uneven sky.
ExampleScene& furnished() {
    static ExampleScene example;
    if (!example.scene.entities.empty()) return example;
    PreparedMesh floor_mesh = prepared_as_is(square_mesh(6, 0, 8));
    floor_mesh.coarse = square_mesh(6, 0);
    Material lacquer = glossy(40, LobeConvention::povray);
    lacquer.diffuse = Rgb(0.4f, 0.2f, 0.1f);
    lacquer.specular = Rgb(0.3f);
    const auto floor = example.add_entity(floor_mesh, matte(0.7f), 6, 18);
    const auto box = example.add_entity(box_mesh({-0.5f, 0, -0.5f}, {0.5f, 1, 0.5f}, 4), lacquer, 2000, 2000);
    example.scene.instances = {{floor, {}}, {box, {{0.3f, 0, 0.2f}, 1}}, {box, {{-1.4f, 0, 0.1f}, 0.7f}}};
    example.scene.environment = environment(
        [](const Vec3d& d) { return 1 + 3 * std::exp(8 * (d.x * 0.5 + d.y * 0.7 + d.z * 0.5 - 1)); });
    example.scene.eye = {3, 2, 4};
    return example;
}

TEST(Renderer, AgreesWithTheDenseOracle) {
    const auto found = furnished().radiance(), wanted = furnished().dense();
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        double error = 0, norm = 0;
        for (std::size_t v = 0; v < wanted[i].size(); ++v)
            for (int channel = 0; channel < 3; ++channel) {
                error += std::pow(double(found[i][v][channel]) - wanted[i][v][channel], 2);
                norm += std::pow(double(wanted[i][v][channel]), 2);
            }
        // The contacts on the floor are between samples of the planar sampler.
        EXPECT_LT(std::sqrt(error / norm), i == 0 ? 0.06 : 0.015) << "instance " << i;
    }
}

TEST(Renderer, EqualsTheDenseOracleWhereNothingIsTruncatedOrInterpolated) {
    RenderSettings settings;
    settings.face_size = ExampleScene::size;
    settings.light_coefficients = 0;
    settings.exact_triangles = 1000;
    const auto found = total(*scene_radiance(furnished().scene, settings)), wanted = furnished().dense();
    for (std::size_t i = 0; i < wanted.size(); ++i)
        for (std::size_t v = 0; v < wanted[i].size(); ++v)
            for (int channel = 0; channel < 3; ++channel)
                EXPECT_NEAR(found[i][v][channel], wanted[i][v][channel], 2e-3 * (1 + wanted[i][v][channel]));
}

/// Returns the RMS difference over vertices and channels.
double difference(const SceneColours& a, const SceneColours& b) {
    double sum = 0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        for (std::size_t v = 0; v < a[i].size(); ++v, count += 3)
            for (int channel = 0; channel < 3; ++channel)
                sum += std::pow(double(a[i][v][channel]) - b[i][v][channel], 2);
    return std::sqrt(sum / double(count));
}

TEST(Renderer, OcclusionIsExactWhereRequested) {
    RenderSettings settings;
    settings.face_size = ExampleScene::size;
    settings.light_coefficients = 0;
    settings.exact_triangles = 2;  // the floor
    const auto radiance = [&](Occlusion occlusion, float error = 0) {
        settings.occlusion = occlusion;
        settings.occlusion_error = error;
        return total(*scene_radiance(furnished().scene, settings));
    };
    const auto dense = furnished().dense(), fields = radiance(Occlusion::fields),
               exact = radiance(Occlusion::exact);
    EXPECT_LT(difference(exact, dense), 2e-3);
    EXPECT_GT(difference(fields, dense), 5 * difference(exact, dense));
    // Both limits of the automatic choice, and a tolerance between them.
    EXPECT_EQ(radiance(Occlusion::automatic, 0), exact);
    EXPECT_EQ(radiance(Occlusion::automatic, 1), fields);
    const double some = difference(radiance(Occlusion::automatic, 0.05f), dense);
    EXPECT_GT(some, difference(exact, dense));
    EXPECT_LT(some, difference(fields, dense));
}

TEST(Renderer, InACrowdOnlyTheNearestAreRasterized) {
    ExampleScene example;
    const auto floor = example.add_entity(square_mesh(0.2f, 0), matte(1)),
               ball = example.add_entity(sphere_mesh({0, 0.3f, 0}, 0.3f, 8), matte(0.5f));
    example.scene.instances = {{floor, {}}};
    const auto add_ball = [&](int i, float distance) {
        const double azimuth = 0.7 * i;
        example.scene.instances.push_back(
            {ball, {Vec3f(Vec3d(distance * std::cos(azimuth), 0, distance * std::sin(azimuth))), 1}});
    };
    example.scene.environment = environment([](const Vec3d& d) { return 1 + d.x; });
    RenderSettings settings;
    settings.face_size = ExampleScene::size;
    settings.exact_triangles = 2;
    settings.occlusion_error = 0;
    const auto differs = [&] {
        settings.occlusion = Occlusion::automatic;
        const auto automatic = total(*scene_radiance(example.scene, settings));
        settings.occlusion = Occlusion::exact;
        return difference({automatic[0]}, {(total(*scene_radiance(example.scene, settings)))[0]}) > 1e-5;
    };
    for (int i = 0; i < 8; ++i) add_ball(i, 1);
    EXPECT_FALSE(differs());
    add_ball(8, 1.5f);
    EXPECT_TRUE(differs());
}

TEST(Renderer, PointsInsideExactOccludersAreBlack) {
    ExampleScene example;
    const auto small = example.add_entity(box_mesh({-0.1f, -0.1f, -0.1f}, {0.1f, 0.1f, 0.1f}), matte(1)),
               large = example.add_entity(sphere_mesh({0, 0, 0}, 1, 20), matte(1));
    example.scene.instances = {{small, {{0.2f, 0.1f, 0}, 1}}, {large, {}}};
    example.scene.environment = environment([](const Vec3d&) { return 1.0; });
    const auto radiance = example.radiance();
    for (const Rgb& r : radiance[0]) EXPECT_EQ(r, Rgb(0.0f));
}

TEST(Renderer, DoesNotDependOnTheNumberOfThreads) {
    const auto wanted = furnished().radiance();
    for (const std::size_t threads : {1u, 2u, 8u}) {
        EXPECT_EQ(with_threads(threads, [] { return furnished().radiance(); }), wanted) << threads;
    }
}

TEST(Renderer, APartialShadingHasTheRadianceAndMemoryOfItsPoints) {
    ExampleScene example;
    const std::size_t ball = example.add_entity(sphere_mesh({0, 0, 0}, 1, 8), matte(0.6f));
    for (const float x : {0.0f, 2.1f, 4.2f, 6.3f}) example.scene.instances.push_back({ball, {{x, 0, 0}, 1}});
    example.scene.environment = environment([](const Vec3d& w) { return 1 + w.y; });
    const SceneColours whole = example.radiance();
    const std::size_t vertices = whole[0].size(), begin = vertices + vertices / 2, end = 3 * vertices;
    std::vector<Outgoing> share;
    const auto shade_share = [&](const SharedLoop& loop) -> Result<Done> {
        EXPECT_EQ(loop.points, 4 * vertices);
        Result<std::vector<Outgoing>> shaded = loop.shaded(begin, end);
        if (!shaded) return shaded.error();
        share = *std::move(shaded);
        return Done{};
    };
    const auto radiance_with = [&](const PointSharing& sharing) {
        RenderSettings settings;
        settings.face_size = ExampleScene::size;
        const ShadingGeometry geometry = *shading_geometry(example.scene, settings);
        const SceneLight light = scene_light(example.scene, settings);
        return total(*scene_radiance({example.scene, geometry, light, settings, nullptr, nullptr, &sharing}));
    };
    const SceneColours part = radiance_with({shade_share, /*has_all=*/false});
    EXPECT_TRUE(part[0].empty() && part[3].empty());
    EXPECT_TRUE(part[2] == whole[2]);
    ASSERT_EQ(share.size(), end - begin);
    // The other process stores the points of the first, and shades the others.
    const auto join = [&](const SharedLoop& loop) -> Result<Done> {
        loop.take(begin, share);
        for (const auto& [first, last] : {std::pair(std::size_t(0), begin), std::pair(end, loop.points)}) {
            Result<std::vector<Outgoing>> shaded = loop.shaded(first, last);
            if (!shaded) return shaded.error();
            loop.take(first, *shaded);
        }
        return Done{};
    };
    EXPECT_TRUE(radiance_with({join, /*has_all=*/true}) == whole);
}

TEST(Renderer, LessDepthIsCoarserButNear) {
    const auto wanted = furnished().radiance();
    double before = 0;
    for (const int depth : {5, 4, 2}) {
        const auto found = furnished().radiance(depth);
        double error = 0;
        for (std::size_t i = 0; i < wanted.size(); ++i)
            for (std::size_t v = 0; v < wanted[i].size(); ++v)
                error += std::abs(double(found[i][v].x) - wanted[i][v].x);
        EXPECT_GE(error, before) << depth;
        before = error;
    }
    EXPECT_GT(before, 0);
}

TEST(BuriedFill, BuriedVerticesTakeTheMeanOfTheirNeighbours) {
    Mesh mesh = square_mesh(2, 0, 2);  // vertex 4 is the middle of nine
    std::vector<Rgb> radiance(9, Rgb(1.0f));
    std::vector<std::uint8_t> buried(9, 0);
    radiance[4] = Rgb(0.0f);
    buried[4] = 1;
    buried[0] = 1;
    radiance[0] = Rgb(0.0f);
    for (std::size_t v : {1u, 2u, 3u, 5u, 6u, 7u, 8u}) radiance[v] = Rgb(2.0f);
    BuriedFill(mesh, buried)(radiance);
    EXPECT_NEAR(radiance[4].x, 2, 1e-6);
    EXPECT_NEAR(radiance[0].x, 2, 1e-6);
}

TEST(BuriedFill, NeedsOnlyTheSourcesOfChosenVertices) {
    constexpr std::size_t across = 9;
    const Mesh mesh = square_mesh(2, 0, across - 1);
    std::vector<std::uint8_t> buried(across * across, 0);
    for (std::size_t row = 2; row < 7; ++row)  // three deep
        for (std::size_t column = 2; column < 7; ++column) buried[row * across + column] = 1;
    const BuriedFill fill(mesh, buried);
    std::vector<Rgb> all;
    for (std::size_t v = 0; v < buried.size(); ++v)
        all.push_back(buried[v] ? Rgb(0.0f) : Rgb(float(1 + v % 7)));
    const std::vector<Rgb> before = all;
    fill(all);
    for (const std::size_t chosen : {4 * across + 4, 2 * across + 2, std::size_t(0)}) {
        std::vector<std::uint8_t> is_chosen(buried.size(), 0);
        is_chosen[chosen] = 1;
        fill.add_sources(is_chosen);
        std::vector<Rgb> some(buried.size(), Rgb(-1e9f));
        std::size_t count = 0;
        for (std::size_t v = 0; v < some.size(); ++v)
            if (is_chosen[v]) some[v] = before[v], ++count;
        fill(some);
        EXPECT_EQ(some[chosen], all[chosen]) << chosen;
        EXPECT_LT(count, buried.size()) << chosen;
    }
}

}  // namespace
}  // namespace haarfield
