#include "shading/bake/ray_renderer.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <random>

#include "shading/bake/render_passes.h"
#include "shading/bake/scrambled_sobol.h"
#include "shading/bounces/cosine_directions.h"
#include "shading/bounces/fine_surface.h"
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
    const SceneColours radiance = total(*ray_scene_radiance(example.scene, {4096}));
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

TEST(RayRenderer, FocusedSamplesHaveTheSameMeanAndLessNoiseWhereLittleLightArrives) {
    // Below a wide roof, which blocks the bright zenith.
    ExampleScene example;
    example.scene.instances = {{example.add_entity(square_mesh(0.1f, 0), matte(0.5f)), {}},
                               {example.add_entity(square_mesh(3, 0), matte(0.5f)), {{0, 0.5f, 0}, 1}}};
    example.scene.environment =
        environment([](const Vec3d& direction) { return direction.y > 0.9 ? 1000.0 : 1.0; });
    example.scene.environment.suns = {{Vec3f(0, 1, 0), 0.01f, Rgb(1000)},
                                      {Vec3f(0.995f, 0.1f, 0), 0.01f, Rgb(3)}};
    example.scene.eye = {0, 0.2f, 1};
    const SurfacePoint point = surface_point(example.scene.entities[0], 0);
    const ShadingPoint at = shading_point(example.scene, example.scene.instances[0], point);
    const RayScene plain(example.scene);
    RayScene focused(example.scene);
    focused.focus(std::vector<SurfacePlace>(256, {at.from, at.brdf.normal}));
    const auto estimate = [&](const RayScene& rays, std::uint32_t samples, std::uint32_t seed) {
        return double(ray_radiance(rays, 0, point, samples, seed).total().y);
    };
    const double exact = estimate(plain, 1u << 20, 1);
    EXPECT_NEAR(estimate(focused, 1u << 17, 2) / exact, 1, 0.01);
    const auto variance = [&](const RayScene& rays) {
        double sum = 0;
        for (std::uint32_t seed = 0; seed < 64; ++seed)
            sum += std::pow(estimate(rays, 64, seed) - exact, 2) / 64;
        return sum;
    };
    EXPECT_LT(variance(focused), variance(plain) / 4);

    // In the open, samples are the same.
    const Plane plane(matte(0.5f));
    const SurfacePoint in_open = surface_point(plane.scene.entities[0], 0);
    RayScene unchanged(plane.scene);
    unchanged.focus(std::vector<SurfacePlace>(16, {Vec3f(0, 0.01f, 0), Vec3f(0, 1, 0)}));
    EXPECT_EQ(ray_radiance(unchanged, 0, in_open, 64, 1).total(), plane.at(64));
}

TEST(RayRenderer, SetsOfSharedSamplesAreThoseOfTheirNumbersAsSeeds) {
    const Boxes boxes;
    const RayScene rays(boxes.scene);
    const DirectRays shared(rays, 256, 4);
    for (std::size_t i = 0; i < boxes.scene.instances.size(); ++i) {
        const ShadedEntity& entity = boxes.scene.entities[boxes.scene.instances[i].entity];
        const SurfacePoint point = surface_point(entity, 1);
        const ShadingPoint at = shading_point(boxes.scene, boxes.scene.instances[i], point);
        for (const std::uint32_t number : {2u, 6u})
            EXPECT_EQ(shared.radiance(i, at, entity.materials[point.material], number).total(),
                      ray_radiance(rays, i, point, 256, 2).total());
    }
    EXPECT_EQ(DirectRays::set_count(1024), 64u);
    EXPECT_EQ(DirectRays::set_count(1u << 16), 4u);
    EXPECT_EQ(DirectRays::set_count(1u << 20), 1u);
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
        return total(*ray_scene_radiance(boxes.scene, {48, any_bounces}));
    };
    EXPECT_EQ(radiance(1), radiance(3));
}

/// A closed room of equal walls, in darkness.
struct ClosedRoom : ExampleScene {
    explicit ClosedRoom(const Material& material, const Mesh& mesh = box_mesh({-1, -1, -1}, {1, 1, 1}, 3)) {
        Mesh walls = mesh;
        for (Vec3f& normal : walls.normals) normal = -normal;
        for (auto& triangle : walls.triangles) std::swap(triangle[1], triangle[2]);
        scene.instances = {{add_entity(walls, material), {{1, 2, 3}, 1.5f}}};
        scene.environment = environment([](const Vec3d&) { return 0.0; }, 16);
    }
    /// All walls emit light.
    void light_walls(const Rgb& radiance) {
        ShadedEntity& entity = scene.entities[0];
        for (const auto& [a, b, c] : entity.mesh->triangles)
            entity.emitters.push_back(
                {{entity.mesh->positions[a], entity.mesh->positions[b], entity.mesh->positions[c]},
                 radiance});
    }
    /// Returns the mean radiance.
    double mean(const RaySettings& settings) const {
        double sum = 0;
        const SceneColours radiance = total(*ray_scene_radiance(scene, settings));
        for (const Rgb& each : radiance[0]) sum += double(each.x) / double(radiance[0].size());
        return sum;
    }
};

TEST(RayRenderer, AWhiteRoomHasTheSeriesOfItsBounces) {
    for (const double albedo : {0.3, 0.8}) {
        ClosedRoom room(matte(float(albedo)));
        room.light_walls(Rgb(2.0f));
        double wanted = 0, last = 2;
        for (const int bounces : {0, 1, 2}) {
            wanted += last *= albedo;
            EXPECT_NEAR(room.mean({1024, bounces}) / wanted, 1, 0.01) << albedo << ", " << bounces;
        }
        EXPECT_NEAR(room.mean({1024, any_bounces}) * (1 - albedo) / (2 * albedo), 1, 0.01) << albedo;
    }
}

TEST(RayRenderer, ImagesTintWhatSurfacesReflectAndNotWhatVerticesReceive) {
    ClosedRoom room(matte(0.8f));
    room.light_walls(Rgb(1.0f));
    const std::vector<Rgb> tints(room.scene.entities[0].mesh->positions.size(), Rgb(0.5f));
    room.scene.entities[0].tints = tints;
    EXPECT_NEAR(room.mean({1024, any_bounces}) / (0.8 * (1 + 0.4 / (1 - 0.4))), 1, 0.01);
}

TEST(RayRenderer, ALampLightsAClosedSphereByTheSeriesOfItsBounces) {
    ClosedRoom room(matte(0.6f), sphere_mesh({0, 0, 0}, 1, 24));
    Lamp lamp;
    lamp.position = {1, 2, 3};
    room.scene.lamps = {lamp};
    EXPECT_NEAR(room.mean({16, 0}) / 0.6, 1, 0.01);
    EXPECT_NEAR(room.mean({1024, any_bounces}) / (0.6 / (1 - 0.6)), 1, 0.01);
}

TEST(RayRenderer, AGlossyWallReflectsTheRoom) {
    Material lacquer = glossy(20, LobeConvention::physical);
    lacquer.diffuse = Rgb(0.5f);
    lacquer.specular = Rgb(0.4f);
    ClosedRoom room(lacquer);
    room.light_walls(Rgb(1.0f));
    room.scene.eye = {1, 2, 3};
    // Light of radiance L from all sides: the lobe reflects as much of it as of the walls' own light. Only
    // diffuse reflections are reflected further: L = 0.5 + 0.25 + ... = 1.
    // All vertices share the samples, whose noise does not average out.
    const SceneRadiance direct = *ray_scene_radiance(room.scene, {1 << 13}),
                        all = *ray_scene_radiance(room.scene, {1 << 13, any_bounces});
    double by_walls = 0, by_room = 0;
    for (std::size_t v = 0; v < direct[0].size(); ++v) {
        by_walls += double(direct[0][v].specular.x);
        by_room += double(all[0][v].specular.x - direct[0][v].specular.x);
    }
    EXPECT_GT(by_walls, 0.05 * double(direct[0].size()));
    EXPECT_NEAR(by_room / by_walls, 1, 0.01);
}

TEST(RayRenderer, PathsAgreeWithPathsOfSingleRaysInDistantLight) {
    const Boxes boxes;
    const RayScene rays(boxes.scene);
    const FineSurface surface(boxes.scene);
    const RayShader shader(boxes.scene, {1 << 14, any_bounces});
    std::mt19937 random(7);
    const auto number = [&] { return float(random() >> 8) / float(1 << 24); };
    const auto place = [&] {
        const float x = number();
        return Vec2f(x, number());
    };
    // The light of single rays: no technique but the cosine, except for the small sun.
    double found = 0, wanted = 0;
    constexpr int paths = 40000;
    for (const std::uint32_t v : {6u, 7u, 12u, 17u}) {
        const ShadingPoint start = shading_point(boxes.scene, boxes.scene.instances[0], v);
        found += double(shader.indirect_radiance(0, v, boxes.scene.entities[0].materials[0]).diffuse.x);
        for (int path = 0; path < paths; ++path) {
            Vec3f from = start.from;
            Vec3f direction = cosine_direction(place(), start.brdf.normal, axes_across(start.brdf.normal));
            double carried = 0.6;
            for (;;) {
                const std::optional<SurfaceHit> hit = surface.first_hit(boxes.scene, from, direction);
                if (!hit || hit->is_back) break;
                const ShadedEntity& entity =
                    boxes.scene.entities[boxes.scene.instances[hit->instance].entity];
                const auto& [a, b, c] = entity.mesh->triangles[hit->triangle];
                const std::vector<Vec3f>& at = entity.mesh->positions;
                const Vec3f normal = (at[b] - at[a]).cross(at[c] - at[a]).normalized();
                from += direction * hit->distance + normal * 1e-4f;
                const double albedo = double(entity.materials[entity.mesh->vertex_materials[a]].diffuse.x);
                const LightSample light = rays.environment.sample({double(number()), double(number())});
                const double cosine = double(normal.dot(light.direction));
                if (cosine > 0 && !rays.rays.is_blocked(from, light.direction))
                    wanted +=
                        carried * albedo / pi * cosine * double(light.radiance.x) / light.density / paths;
                carried *= albedo;
                direction = cosine_direction(place(), normal, axes_across(normal));
            }
        }
    }
    EXPECT_GT(found, 0.05);
    EXPECT_NEAR(found / wanted, 1, 0.02);
}

TEST(RayRenderer, PassesOfRaysHaveIndirectLight) {
    ClosedRoom room(matte(0.5f));
    room.light_walls(Rgb(1.0f));
    RenderSettings settings;
    settings.face_size = ExampleScene::size;
    settings.bounces.most = any_bounces;
    const ShadingGeometry geometry = *shading_geometry(room.scene, settings);
    const SceneLight light = scene_light(room.scene, settings);
    const PointShading shading{room.scene, geometry, light, settings};
    const SceneRadiance full = *ray_scene_radiance(room.scene, {4096, any_bounces});
    const std::vector<std::span<const Outgoing>> spans(full.begin(), full.end());
    const RenderPass wanted[] = {RenderPass::indirect, RenderPass::irradiance};
    const std::vector<SceneRadiance> passes =
        *render_passes({shading, {}, false, false, 4096}, spans, wanted);
    double indirect = 0, irradiance = 0;
    for (const Outgoing& value : passes[0][0])
        indirect += double(value.diffuse.x) / double(passes[0][0].size());
    for (const Outgoing& value : passes[1][0])
        irradiance += double(value.diffuse.x) / double(passes[1][0].size());
    EXPECT_NEAR(indirect, 0.5, 0.005);
    EXPECT_NEAR(irradiance, 2 * pi, 0.02 * pi) << "the walls reflect half of the light, white paint all";
}

TEST(ScrambledSobol, SortedPointsAreTheSameOnesNextToEachOther) {
    const ScrambledSobol points(5);
    std::vector<std::array<double, 2>> sorted = sorted_points(points, 256), plain;
    for (std::uint32_t i = 0; i < 256; ++i) plain.push_back(points(i));
    double steps = 0;
    for (std::size_t i = 1; i < sorted.size(); ++i)
        steps += std::hypot(sorted[i][0] - sorted[i - 1][0], sorted[i][1] - sorted[i - 1][1]) / 255;
    EXPECT_LT(steps, 0.15) << "0.52 in random order";
    std::ranges::sort(sorted);
    std::ranges::sort(plain);
    EXPECT_EQ(sorted, plain);
}

TEST(ScrambledSobol, ShuffledRunsAreRuns) {
    for (const std::uint32_t run : {4u, 64u, 1024u})
        for (const std::uint32_t first : {0u, run, 5 * run}) {
            std::vector<std::uint32_t> found;
            for (std::uint32_t i = 0; i < run; ++i) found.push_back(shuffled(first + i, 99));
            std::ranges::sort(found);
            EXPECT_EQ(found.front() % run, 0u);
            EXPECT_EQ(found.back() - found.front(), run - 1);
            EXPECT_EQ(std::ranges::adjacent_find(found), found.end());
        }
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
