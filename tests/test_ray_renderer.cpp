#include "shading/bake/ray_renderer.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "shading/bake/scrambled_sobol.h"
#include "tests/fixtures/example_scene.h"

namespace haarfield {
namespace {

struct Plane : ExampleScene {
    explicit Plane(const Material& material) {
        scene.instances = {{add_entity(square_mesh(0.01f, 0), material), {}}};
        scene.environment = environment([](const Vec3d&) { return 1.0; });
        scene.eye = {0, 100, 0};
    }
    Rgb at(std::uint32_t samples, std::uint32_t seed = 1) const {
        return ray_radiance(RayScene(scene), 0, surface_point(scene.entities[0], 0), samples, seed).total();
    }
};

TEST(RayRenderer, FurnaceGivesTheAlbedo) {
    ExampleScene example;
    example.scene.instances = {
        {example.add_entity(sphere_mesh({0, 0, 0}, 1, 6), matte(0.6f)), {{3, 1, 2}, 2}}};
    example.scene.environment = environment([](const Vec3d&) { return 1.0; });
    const SceneColours radiance = total(*ray_scene_radiance(example.scene, 4096));
    for (const Rgb& r : radiance[0])
        for (int channel = 0; channel < 3; ++channel) EXPECT_NEAR(r[channel], 0.6, 0.002);
}

TEST(RayRenderer, LobesHaveTheirClosedForms) {
    for (const float shininess : {10.0f, 60.0f, 300.0f}) {
        EXPECT_NEAR(Plane(glossy(shininess, LobeConvention::physical)).at(1 << 14).x, 1, 3e-3) << shininess;
        EXPECT_NEAR(Plane(glossy(shininess, LobeConvention::povray)).at(1 << 14).x * (shininess + 1) / 2, 1,
                    3e-3)
            << shininess;
    }
    // Viewed along the normal, half vectors have half the angle: 2 int_0^1 ((1 + c) / 2)^(n / 2) dc.
    Material blinn = glossy(1, LobeConvention::povray);
    blinn.phong = 0;
    blinn.blinn = 1;
    blinn.roughness = 0.02f;
    const double exponent = 25, exact = 4 / (exponent + 1) * (1 - std::pow(0.5, exponent + 1));
    EXPECT_NEAR(Plane(blinn).at(1 << 14).x / exact, 1, 3e-3);
}

TEST(RayRenderer, ASunLightsByTheCosineOverThePixelsArea) {
    Plane plane(matte(0.5f));
    LatLongImage image = environment([](const Vec3d&) { return 0.0; }, 64);
    const int row = 6, column = 11;
    image.pixels[row * 64 + column] = Rgb(1000, 500, 250);
    plane.scene.environment = image;
    // int cos over the pixel: of the sine of the latitude, from bottom to top.
    const double top = pi * (0.5 - row / 32.0), bottom = pi * (0.5 - (row + 1) / 32.0);
    const auto primitive = [](double sine) { return sine * sine / 2; };
    const double exact =
        0.5 / pi * 1000 * 2 * pi / 64 * (primitive(std::sin(top)) - primitive(std::sin(bottom)));
    const Rgb found = plane.at(4096);
    EXPECT_NEAR(found.x / exact, 1, 2e-3);
    EXPECT_NEAR(found.y / found.x, 0.5, 1e-5);
    plane.scene.environment.image = environment([](const Vec3d&) { return 0.0; }, 64);
    plane.scene.environment.suns = {{Vec3f(Vec3d(0.6, 0.8, 0)), 0.05f, Rgb(2)}};
    EXPECT_NEAR(plane.at(1024).x, 0.5 / pi * 2 * 0.8, 1e-3);
}

TEST(RayRenderer, AWallBlocksHalfOfAUniformSky) {
    ExampleScene example;
    example.scene.instances = {
        {example.add_entity(square_mesh(0.001f, 0), matte(1.0f)), {}},
        {example.add_entity(box_mesh({0.01f, -1, -1000}, {1, 1000, 1000}), matte(1.0f)), {}}};
    example.scene.environment = environment([](const Vec3d&) { return 1.0; });
    const Rgb found =
        ray_radiance(RayScene(example.scene), 0, surface_point(example.scene.entities[0], 0), 1 << 15, 3)
            .total();
    EXPECT_NEAR(found.x, 0.5, 2e-3);
}

TEST(RayRenderer, SurfacesThatTouchEachOtherAreDark) {
    ExampleScene example;
    const std::size_t square = example.add_entity(square_mesh(1, 0, 4), matte(0.7f)),
                      box =
                          example.add_entity(box_mesh({-0.2f, 0, -0.2f}, {0.2f, 0.3f, 0.2f}, 4), matte(0.5f));
    const Placement small{{0.1f, 0, 0.1f}, 0.1f};
    example.scene.environment = environment([](const Vec3d&) { return 1.0; });
    const auto mean_of_bottom = [&](std::vector<ShadedInstance> instances) {
        example.scene.instances = std::move(instances);
        const RayScene rays(example.scene);
        const Mesh& mesh = *example.scene.entities[example.scene.instances[0].entity].mesh;
        double sum = 0;
        int count = 0;
        for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
            if (mesh.positions[v].y != 0 || std::abs(mesh.normals[v].y) < 0.9f) continue;
            sum += double(
                ray_radiance(rays, 0,
                             surface_point(example.scene.entities[example.scene.instances[0].entity], v),
                             1024, 1)
                    .total()
                    .x);
            ++count;
        }
        return sum / count;
    };
    EXPECT_NEAR(mean_of_bottom({{box, {}}}), 0.5, 0.01) << "in the open";
    EXPECT_NEAR(mean_of_bottom({{box, {}}, {square, {}}}), 0, 0.01) << "on a floor";
    EXPECT_NEAR(mean_of_bottom({{square, small}, {square, {}}}), 0.7, 0.01) << "a sheet upon a sheet";
}

TEST(RayRenderer, AnEmitterHasLambertsIrradiance) {
    ExampleScene example;
    example.scene.instances = {{example.add_entity(square_mesh(0.01f, 0), matte(0.5f)), {}}};
    example.scene.environment = environment([](const Vec3d&) { return 0.0; }, 16);
    const std::array<Vec3f, 3> corners{Vec3f(-0.5f, 0.4f, 0.2f), Vec3f(0.6f, 0.5f, 0.1f),
                                       Vec3f(0.1f, 0.6f, -0.7f)};
    std::array<Vec3f, 3> facing = corners;
    if ((corners[1] - corners[0]).cross(corners[2] - corners[0]).y > 0) std::swap(facing[1], facing[2]);
    example.scene.entities[0].emitters = {{facing, Rgb(3, 2, 1)}};
    const SurfacePoint point = surface_point(example.scene.entities[0], 0);
    std::array<Vec3d, 3> exact_corners;
    for (std::size_t k = 0; k < 3; ++k) exact_corners[k] = Vec3d(facing[k]);
    const double irradiance = triangle_irradiance(exact_corners, Vec3d(point.sample), Vec3d(0, 1, 0));
    ASSERT_GT(irradiance, 0.1);
    EXPECT_NEAR(
        ray_radiance(RayScene(example.scene), 0, point, 1 << 14, 5).total().x / (0.5 / pi * 3 * irradiance),
        1, 3e-3);
    std::swap(example.scene.entities[0].emitters[0].corners[1],
              example.scene.entities[0].emitters[0].corners[2]);
    EXPECT_EQ(ray_radiance(RayScene(example.scene), 0, point, 1 << 10, 5).total().x, 0) << "its back is dark";
}

/// Boxes on a floor, in light with a sun of a few pixels.
struct Boxes : ExampleScene {
    Boxes() {
        Material lacquer = glossy(40, LobeConvention::povray);
        lacquer.diffuse = Rgb(0.4f, 0.3f, 0.2f);
        lacquer.blinn = 0.5f;
        scene.instances = {
            {add_entity(square_mesh(4, 0, 4), matte(0.6f)), {}},
            {add_entity(box_mesh({-0.4f, 0.1f, -0.3f}, {0.4f, 0.5f, 0.3f}, 2), lacquer), {}},
            {add_entity(box_mesh({0.6f, 0.1f, -0.3f}, {0.9f, 0.9f, 0.3f}, 2), matte(0.5f)), {}}};
        const Vec3d sun = Vec3d(0.5, 0.6, 0.3).normalized();
        scene.environment = environment(
            [&](const Vec3d& d) { return 0.4 + 0.2 * d.y + (d.dot(sun) > 0.9998 ? 900.0 : 0.0); });
        scene.eye = {1, 3, 4};
    }
};

TEST(RayRenderer, AgreesWithDenseSums) {
    const Boxes boxes;
    RenderSettings settings;
    settings.face_size = 256;
    const DenseScene dense(boxes.scene, settings.face_size);
    DenseShader shader(dense);
    const RayScene rays(boxes.scene);
    double error = 0, energy = 0;
    for (std::size_t i = 0; i < boxes.scene.instances.size(); ++i) {
        const ShadedEntity& entity = boxes.scene.entities[boxes.scene.instances[i].entity];
        for (std::uint32_t v = 0; v < entity.mesh->positions.size(); v += 4) {
            if (entity.occlusion->samples().buried[v]) continue;
            const Rgb exact = shader.radiance(i, surface_point(entity, v)).total(),
                      found = ray_estimate(rays, i, v, 1 << 15).radiance;
            error += squared(exact - found);
            energy += squared(exact);
        }
    }
    EXPECT_LT(std::sqrt(error / energy), 0.004);
}

TEST(RayRenderer, HasSmallerErrorsThanRandomSamplesAndEstimatesThem) {
    const Boxes boxes;
    const RayScene rays(boxes.scene);
    const Rgb exact = ray_estimate(rays, 0, 12, 1 << 18).radiance;
    const auto error = [&](std::uint32_t samples) {
        double sum = 0;
        for (std::uint32_t seed = 0; seed < 32; ++seed)
            sum += squared(
                ray_radiance(rays, 0, surface_point(boxes.scene.entities[0], 12), samples, seed).total() -
                exact);
        return std::sqrt(sum / 32);
    };
    EXPECT_LT(error(4096), error(64) / 8 / 1.5) << "64 times as many samples";
    const RayEstimate estimate = ray_estimate(rays, 0, 12, 1024);
    const double deviation = std::sqrt(squared(estimate.deviation));
    EXPECT_LT(std::sqrt(squared(estimate.radiance - exact)), 5 * deviation);
    EXPECT_LT(deviation, error(128));
}

TEST(RayRenderer, IsTheSameForAnyNumberOfThreads) {
    const Boxes boxes;
    const auto radiance = [&](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        return total(*ray_scene_radiance(boxes.scene, 48));
    };
    EXPECT_EQ(radiance(1), radiance(3));
}

TEST(ScrambledSobol, EachRunOfAPowerOfTwoFillsAllStrips) {
    for (std::uint32_t seed : {1u, 77u, 123456u}) {
        const ScrambledSobol points(seed);
        constexpr std::uint32_t count = 64;
        for (std::uint32_t across : {1u, 4u, 8u, 64u}) {
            std::vector<int> filled(count);
            for (std::uint32_t i = 0; i < count; ++i) {
                const auto [x, y] = points(i);
                ++filled[std::size_t(x * across) * (count / across) + std::size_t(y * (count / across))];
            }
            for (const int n : filled) EXPECT_EQ(n, 1) << seed << ", " << across;
        }
    }
    EXPECT_NE(ScrambledSobol(1)(5), ScrambledSobol(2)(5));
}

}  // namespace
}  // namespace haarfield
