#include "shading/bake/source_light.h"

#include <gtest/gtest.h>

#include <random>

#include "shading/bake/renderer.h"
#include "tests/fixtures/example_scene.h"
#include "tests/fixtures/with_threads.h"

namespace haarfield {
namespace {

/// Tests whether a ray hits any triangle of the scene, by Cramer's rule in double. `margin`: the distance of
/// the closest decision from an edge, or from either end of the ray.
bool meets_a_triangle(const ExampleScene& example, const Vec3d& from, const Vec3d& direction,
                      double& margin) {
    bool meets = false;
    margin = 1;
    for (const ShadedInstance& instance : example.scene.instances) {
        const Mesh& mesh = example.mesh(instance.entity).original;
        for (const auto& triangle : mesh.triangles) {
            std::array<Vec3d, 3> p;
            for (std::size_t k = 0; k < 3; ++k)
                p[k] = instance.placement.point_to_world(Vec3d(mesh.positions[triangle[k]]));
            const Vec3d u = p[1] - p[0], v = p[2] - p[0], across = direction.cross(v), to = from - p[0];
            const double volume = u.dot(across);
            if (std::abs(volume) < 1e-12) continue;
            const double a = to.dot(across) / volume, b = direction.dot(to.cross(u)) / volume,
                         t = v.dot(to.cross(u)) / volume;
            const double inside = std::min({a, b, 1 - a - b, t});
            margin = std::min(margin, std::abs(inside));
            meets |= inside > 0;
        }
    }
    return meets;
}

struct PostOnAFloor : ExampleScene {
    PostOnAFloor() {
        floor = add_entity(square_mesh(4, 0, 64), matte(0.5f));
        post = add_entity(box_mesh({-0.2f, 0, -0.2f}, {0.2f, 1, 0.2f}, 2), matte(0.5f), 400, 300);
        scene.instances = {
            {floor, {}}, {post, {}}, {post, {{1.1f, 0, 0.7f}, 0.6f, rotation_about({0, 1, 0}, 0.6)}}};
        scene.environment = environment([](const Vec3d& d) { return 0.2 + 0.1 * d.y; });
        scene.environment.suns.push_back({Vec3f(Vec3d(0.6, 0.5, 0.2).normalized()), 0.02f, Rgb(3, 2, 1)});
        scene.eye = {2, 2, 4};
    }
    std::size_t floor, post;
};

TEST(ShadowRays, AgreeWithEveryTriangleInPacketsAndAlone) {
    const PostOnAFloor example;
    ShadowRays rays;
    rays.build(example.scene);
    std::mt19937 random(7);
    const auto uniform = [&](double low, double high) {
        return low + (high - low) * double(random()) / 4294967296.0;
    };
    int met = 0, asked = 0;
    for (int round = 0; round < 60; ++round) {
        std::array<Vec3f, ShadowRays::packet> points;
        for (Vec3f& p : points) p = Vec3f(Vec3d(uniform(-2, 2), uniform(0.01, 1.2), uniform(-2, 2)));
        const Vec3f direction(Vec3d(uniform(-1, 1), uniform(-0.2, 1), uniform(-1, 1)).normalized());
        const std::size_t count = 1 + random() % points.size();
        const auto wanted = static_cast<std::uint16_t>(random());
        const std::uint16_t blocked = rays.blocked(std::span(points).first(count), wanted, direction);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const bool in_packet = blocked >> i & 1u;
            if (i >= count || !(wanted >> i & 1u)) {
                EXPECT_FALSE(in_packet);
                continue;
            }
            EXPECT_EQ(in_packet, rays.is_blocked(points[i], direction));
            double margin;
            const bool meets = meets_a_triangle(example, Vec3d(points[i]), Vec3d(direction), margin);
            if (margin < 1e-4) continue;
            EXPECT_EQ(in_packet, meets) << points[i] << " towards " << direction;
            ++asked;
            met += meets;
        }
    }
    EXPECT_GT(asked, 200);
    EXPECT_GT(met, 20);
    EXPECT_LT(met, asked - 100);
}

TEST(ShadowRays, FollowInstancesThatAreMovedAndTurned) {
    PostOnAFloor example;
    ShadowRays rays;
    rays.build(example.scene);
    const Vec3f beside(-1, 0.5f, 0), east(1, 0, 0);
    EXPECT_TRUE(rays.is_blocked(beside, east));
    example.scene.instances[1].placement.translate = {0, 0, 3};
    rays.place(example.scene);
    EXPECT_FALSE(rays.is_blocked(beside, east));
    const Vec3f left(-0.7f, 0.1f, 2), forwards(0, 0, 1);
    EXPECT_FALSE(rays.is_blocked(left, forwards));
    example.scene.instances[1].placement.rotate = rotation_about({0, 0, 1}, pi / 2);
    rays.place(example.scene);
    EXPECT_TRUE(rays.is_blocked(left, forwards));
}

TEST(SourceLight, ReflectsAsTheMaterialDoes) {
    Material lacquer = glossy(30, LobeConvention::povray), metal = glossy(15, LobeConvention::physical),
             brass = lacquer;
    lacquer.diffuse = Rgb(0.4f, 0.2f, 0.1f);
    lacquer.specular = Rgb(0.3f, 0.3f, 0.2f);
    brass.phong = 0.4f;
    brass.blinn = 0.6f;
    brass.roughness = 0.03f;
    brass.metallic = 0.8f;
    brass.pigment = Rgb(0.8f, 0.4f, 0.2f);
    std::mt19937 random(3);
    const auto direction = [&] {
        const auto coordinate = [&] { return double(random()) / 2147483648.0 - 1; };
        return Vec3f(Vec3d(coordinate(), coordinate(), coordinate()).normalized());
    };
    for (const Material& material : {matte(0.7f), lacquer, metal, brass})
        for (int i = 0; i < 500; ++i) {
            const Vec3f normal = direction(), mirror = mirrored_view(direction() * 5.0f, Vec3f(0.0f), normal),
                        light = i % 2 ? direction() : (mirror + direction() * 0.1f).normalized();
            const Outgoing found = reflectance(surface_brdf<float>(material, normal, mirror), light);
            const auto wanted = reflectance(material, Vec3d(normal), Vec3d(mirror), Vec3d(light));
            for (int c = 0; c < 3; ++c) {
                EXPECT_NEAR(found.diffuse[c], wanted.diffuse[c], 2e-5);
                EXPECT_NEAR(found.specular[c], wanted.specular[c], 2e-5 * (1 + wanted.specular[c]));
            }
        }
}

TEST(SourceLight, CastsTheShadowOfThePostWithItsPenumbra) {
    PostOnAFloor example;
    example.scene.environment.image = environment([](const Vec3d&) { return 0.0; });
    example.scene.instances.pop_back();
    const SceneColours found = example.radiance();
    const Mesh& floor = example.mesh(example.floor).fine;
    const SunDisc& sun = example.scene.environment.suns[0];
    const float lit = 0.5f / float(pi) * sun.direction.y;
    const Vec3d across = Vec3d(sun.direction.x, 0, sun.direction.z).normalized();
    const double rise =
        double(sun.direction.y) / std::hypot(double(sun.direction.x), double(sun.direction.z));
    int dark = 0, bright = 0;
    for (std::size_t v = 0; v < floor.positions.size(); ++v) {
        // Distances of the post's axis along and across the direction of the sun. Near the outline and the
        // top, part of the sun's disc may be visible.
        const Vec3d p(floor.positions[v]);
        const double ahead = -p.dot(across), aside = std::abs(p.cross(across).y);
        const bool is_dark = aside < 0.1 && ahead > 0.35 && (ahead + 0.3) * rise < 0.95;
        const bool is_bright = aside > 0.35 || ahead < -0.35 || (ahead - 0.35) * rise > 1.1;
        const Rgb& radiance = found[0][v];
        if (is_dark) {
            EXPECT_LT(radiance.x, 1e-4f) << p;
            ++dark;
        } else if (is_bright) {
            EXPECT_NEAR(radiance.x, 3 * lit, 0.003f * lit) << p;
            EXPECT_NEAR(radiance.z, lit, 0.001f * lit) << p;
            ++bright;
        }
    }
    EXPECT_GT(bright, 100);
    EXPECT_GT(dark, 10);
}

TEST(SourceLight, IsThatOfTheDenseOracleWithEveryPart) {
    const PostOnAFloor example;
    const SceneColours found = example.radiance(), wanted = example.dense();
    double error = 0, energy = 0;
    for (std::size_t i = 0; i < wanted.size(); ++i)
        for (std::size_t v = 0; v < wanted[i].size(); ++v) {
            error += double((found[i][v] - wanted[i][v]).length2());
            energy += double(wanted[i][v].length2());
        }
    EXPECT_LT(std::sqrt(error / energy), 0.012);
}

TEST(SourceLight, DoesNotDependOnTheNumberOfThreads) {
    const PostOnAFloor example;
    const auto radiance_by = [&](std::size_t threads) {
        return with_threads(threads, [&] { return example.radiance(); });
    };
    const SceneColours wanted = radiance_by(1);
    for (const std::size_t threads : {2u, 5u}) EXPECT_EQ(radiance_by(threads), wanted) << threads;
}

}  // namespace
}  // namespace haarfield
