#include "shading/scene/emitter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "bridge/povray/emitter_lamps.h"
#include "bridge/povray/povray_process.h"
#include "bridge/povray/reference_scene.h"
#include "shading/bake/emitter_light.h"
#include "tests/fixtures/bridge_fixtures.h"
#include "tests/fixtures/example_scene.h"

namespace haarfield {
namespace {

const Rgb glow(2, 1, 0.5f);

std::vector<Emitter> emitters_of(const Mesh& mesh, const Rgb& radiance = glow) {
    std::vector<Emitter> emitters;
    for (const auto& [a, b, c] : mesh.triangles)
        emitters.push_back({{mesh.positions[a], mesh.positions[b], mesh.positions[c]}, radiance});
    return emitters;
}

/// Returns a disc in the plane y = height, facing down.
std::vector<Emitter> disc(float radius, float height, int corners) {
    std::vector<Emitter> emitters;
    const auto at = [&](int i) {
        const double angle = 2 * pi * i / corners;
        return Vec3f(Vec3d(std::cos(angle), 0, std::sin(angle)) * double(radius)) + Vec3f(0, height, 0);
    };
    for (int i = 0; i < corners; ++i) emitters.push_back({{Vec3f(0, height, 0), at(i), at(i + 1)}, glow});
    return emitters;
}

Vec3d irradiance_of(const EmitterTree& tree, const Vec3f& point, const Vec3f& normal,
                    const EmitterCut& cut = {}) {
    std::vector<EmitterPatch> patches;
    find_patches(tree, point, normal, cut, patches);
    Vec3d sum(0.0);
    for (const EmitterPatch& patch : patches) sum += Vec3d(patch.irradiance);
    return sum;
}

TEST(Emitter, TheIrradianceOfADiscFollowsItsFormFactor) {
    const float radius = 0.5f;
    for (const int corners : {400, 4000})
        for (const float height : {0.002f, 0.05f, 0.3f, 1.0f, 4.0f, 50.0f}) {
            const EmitterTree tree = emitter_tree(disc(radius, height, corners));
            const double r2 = squared(radius), exact = pi * r2 / (r2 + squared(height));
            const Vec3d found = irradiance_of(tree, Vec3f(0.0f), Vec3f(0, 1, 0));
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(found[c] / (double(glow[c]) * exact), 1, 0.003) << corners << " at " << height;
            EXPECT_EQ(irradiance_of(tree, Vec3f(0.0f), Vec3f(0, -1, 0)), Vec3d(0.0)) << "below the horizon";
            EXPECT_EQ(irradiance_of(tree, Vec3f(0, 2 * height, 0), Vec3f(0, -1, 0)), Vec3d(0.0)) << "behind";
        }
}

/// The corner of a rectangle a x b at height h above the point, parallel and at right angles (textbook form
/// factors).
TEST(Emitter, TheIrradianceOfARectangleFollowsItsFormFactor) {
    for (const auto& [a, b, h] :
         {std::tuple(0.4, 0.3, 0.5), std::tuple(1.0, 1.0, 0.01), std::tuple(3.0, 0.1, 2.0)}) {
        const float x = float(a), z = float(b), y = float(h);
        const std::vector<Emitter> rectangle{{{Vec3f(0, y, 0), Vec3f(x, y, 0), Vec3f(x, y, z)}, glow},
                                             {{Vec3f(0, y, 0), Vec3f(x, y, z), Vec3f(0, y, z)}, glow}};
        const EmitterTree tree = emitter_tree(rectangle);
        const double A = a / h, B = b / h;
        const double parallel = (A / std::sqrt(1 + A * A) * std::atan(B / std::sqrt(1 + A * A)) +
                                 B / std::sqrt(1 + B * B) * std::atan(A / std::sqrt(1 + B * B))) /
                                2,
                     upright =
                         (std::atan(B) - std::atan(B / std::sqrt(1 + A * A)) / std::sqrt(1 + A * A)) / 2;
        // Whole and clipped triangles.
        double whole = 0;
        for (const Emitter& triangle : rectangle)
            whole += triangle_irradiance(
                {Vec3d(triangle.corners[0]), Vec3d(triangle.corners[1]), Vec3d(triangle.corners[2])},
                Vec3d(0.0), Vec3d(0, 1, 0));
        EXPECT_NEAR(whole / parallel, 1, 1e-6);
        EXPECT_NEAR(irradiance_of(tree, Vec3f(0.0f), Vec3f(0, 1, 0)).x / (double(glow.x) * parallel), 1,
                    0.003);
        EXPECT_NEAR(irradiance_of(tree, Vec3f(0.0f), Vec3f(1, 0, 0)).x / (double(glow.x) * upright), 1, 0.003)
            << a << " x " << b << " at " << h;
    }
}

/// A sphere has the form factor of a disc that faces the point: E = pi L sin^2 of its angular radius, if it
/// is completely above the horizon.
TEST(Emitter, TheIrradianceOfABallFollowsItsSolidAngle) {
    for (const int segments : {16, 64})
        for (const float distance : {0.3f, 1.0f, 6.0f}) {
            const Mesh ball = sphere_mesh({0, distance, 0}, 0.2f, segments);
            const EmitterTree tree = emitter_tree(emitters_of(ball));
            // The exact value for the polyhedron: the sum over its triangles.
            double exact = 0;
            for (const Emitter& triangle : tree.triangles) {
                const auto& [a, b, c] = triangle.corners;
                if ((b - a).cross(c - a).dot(a) < 0)
                    exact += triangle_irradiance({Vec3d(a), Vec3d(b), Vec3d(c)}, Vec3d(0.0), Vec3d(0, 1, 0));
            }
            const double round = pi * squared(0.2f) / squared(distance);
            EXPECT_NEAR(exact / round, 1, segments == 16 ? 0.05 : 0.004);
            EXPECT_NEAR(irradiance_of(tree, Vec3f(0.0f), Vec3f(0, 1, 0)).x / (double(glow.x) * exact), 1,
                        0.005)
                << segments << " segments, " << distance << " away";
        }
}

/// Compares patches with single triangles at arbitrary points: half below the horizon, and to the side.
TEST(Emitter, PatchesAddUpToTheTriangles) {
    const Mesh mesh = joined_meshes(box_mesh({-0.3f, 0.2f, -0.2f}, {0.4f, 0.5f, 0.3f}, 3),
                                    sphere_mesh({0.5f, 0.9f, 0.2f}, 0.25f, 20));
    const EmitterTree tree = emitter_tree(emitters_of(mesh));
    std::mt19937 random(5);
    const auto uniform = [&] { return 2 * double(random()) / 4294967296.0 - 1; };
    double error = 0, energy = 0, fine_error = 0;
    for (int i = 0; i < 300; ++i) {
        const Vec3f point(Vec3d(2 * uniform(), 2 * uniform(), 2 * uniform())),
            normal(Vec3d(uniform(), uniform(), uniform()).normalized());
        double exact = 0;
        for (const Emitter& triangle : tree.triangles) {
            const auto& [a, b, c] = triangle.corners;
            if ((b - a).cross(c - a).dot(a - point) < 0)
                exact += triangle_irradiance({Vec3d(a), Vec3d(b), Vec3d(c)}, Vec3d(point), Vec3d(normal));
        }
        exact *= double(glow.x);
        const double found = irradiance_of(tree, point, normal).x,
                     fine = irradiance_of(tree, point, normal, fine_emitter_cut).x;
        EXPECT_NEAR(found, exact, 0.02 * exact + 1e-3) << point << ", " << normal;
        error += (found - exact) * (found - exact);
        fine_error += (fine - exact) * (fine - exact);
        energy += exact * exact;
    }
    EXPECT_LT(std::sqrt(error / energy), 0.005);
    EXPECT_LT(std::sqrt(fine_error / energy), 0.001);
}

/// An emitting square above a post on a floor.
struct GlowingSquare : ExampleScene {
    GlowingSquare() {
        const std::size_t floor = add_entity(square_mesh(2, 0, 24), matte(0.8f), 1, 1);
        const std::size_t post =
            add_entity(box_mesh({-0.15f, 0, -0.1f}, {0.1f, 0.5f, 0.15f}, 2), matte(0.8f), 1, 1);
        const std::size_t square = add_entity(
            turned_mesh(square_mesh(0.5f, 0, 2), rotation_about({1, 0, 0}, pi)), matte(0.0f), 1, 1);
        scene.instances = {{floor, {}}, {post, {{0.2f, 0, 0}, 1}}, {square, {{-0.2f, 1.2f, 0.1f}, 1}}};
        scene.entities[square].emitters = emitters_of(mesh(square).original);
        scene.environment = constant_environment(4, Rgb(0, 0, 0));
        scene.eye = {0, 2, 4};
    }
};

TEST(Emitter, TheIrradianceOfANeedleIsThatOfItsPieces) {
    constexpr int pieces = 500;
    constexpr float length = 2, width = 5e-6f;
    std::vector<Emitter> needle;
    for (int i = 0; i < pieces; ++i) {
        const float x = length * float(i) / pieces, next = length * float(i + 1) / pieces;
        needle.push_back({{Vec3f(x, 0, 0), Vec3f(next, 0, 0), Vec3f(x, 0, width)}, glow});
    }
    const EmitterTree tree = emitter_tree(needle);
    for (const float distance : {1e-4f, 1e-2f, 1.0f})
        for (const float x : {0.0f, 0.7f}) {
            const Vec3f point(x, -distance, 0.3f * distance), normal(0, 1, 0);
            double exact = 0;
            for (const Emitter& piece : needle) {
                const auto& [a, b, c] = piece.corners;
                exact += triangle_irradiance({Vec3d(a), Vec3d(b), Vec3d(c)}, Vec3d(point), Vec3d(normal));
            }
            ASSERT_GT(exact, 0);
            const Vec3d found = irradiance_of(tree, point, normal);
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(found[c] / (double(glow[c]) * exact), 1, 0.003) << distance << " from " << x;
        }
}

TEST(Emitter, LightsSurfacesAsPovraysLampsDo) {
    const GlowingSquare example;
    const SceneColours tree = example.radiance(), dense = example.dense();
    double error = 0, energy = 0;
    for (std::size_t v = 0; v < tree[0].size(); ++v) {
        error += squared(tree[0][v] - dense[0][v]);
        energy += squared(dense[0][v]);
    }
    EXPECT_LT(std::sqrt(error / energy), 0.02);
    ASSERT_GT(energy, 0);

    Camera camera;
    camera.position = {0, 4, 0.001f};
    camera.target = {0, 0, 0};
    camera.vertical_fov = 2 * std::atan(1.0f / 4);
    camera.width = camera.height = 25;  // a vertex at the centre of each inner pixel
    camera.vertical_fov = 2 * std::atan(25.0f / 24 / 4);
    std::vector<ReferenceInstance> instances;
    for (std::size_t i = 0; i < example.scene.instances.size(); ++i) {
        const ShadedEntity& entity = example.scene.entities[example.scene.instances[i].entity];
        instances.push_back({"instance_" + std::to_string(i), &example.mesh(i).original, entity.materials,
                             example.scene.instances[i].placement});
        instances.back().emitters = entity.emitters;
    }
    const TestFolder folder;
    const Result<ReferenceFiles> files =
        write_reference_scene(folder.path(), "glow", camera, instances, example.scene.environment, 1000);
    ASSERT_TRUE(files) << files.error().message();
    PovrayOptions options;
    options.width = options.height = camera.width;
    options.declarations = {without_background};
    const Result<RenderedScene> picture = rendered_scene(files->scene, options);
    ASSERT_TRUE(picture) << picture.error().message();
    const Mesh& floor = example.mesh(0).fine;
    double difference = 0, light = 0;
    int compared = 0, slipped = 0;
    for (std::size_t v = 0; v < floor.positions.size(); ++v) {
        const Vec3f& p = floor.positions[v];
        const int x = int(std::lround((p.x + 1) * 12)), y = int(std::lround((p.z + 1) * 12));
        // Skips pixels half of which miss the floor, and those of the square and the post.
        if (std::max(std::abs(p.x), std::abs(p.z)) > 0.99f) continue;
        if (p.x < 0.5f && p.x > -0.75f && std::abs(p.z) < 0.6f) continue;
        const Rgb& found = picture->image.pixels[std::size_t(25 * y + x)];
        if (found == Rgb(0.0f) && ++slipped) continue;  // between the triangles at the vertex
        difference += squared(found - tree[0][v]);
        light += squared(tree[0][v]);
        ++compared;
    }
    EXPECT_GT(compared, 300);
    EXPECT_LT(slipped, 5);
    EXPECT_LT(std::sqrt(difference / light), 0.01);
}

TEST(Emitter, PovraysLampsHaveItsPower) {
    const std::vector<Emitter> ball = emitters_of(sphere_mesh({0, 0, 0}, 0.2f, 32));
    const EmitterTree tree = emitter_tree(ball);
    const Vec3d exact = irradiance_of(tree, Vec3f(0.1f, 2, 0), Vec3f(0, -1, 0), fine_emitter_cut);
    for (const std::size_t count : {std::size_t(300), ball.size(), 4 * ball.size()})
        for (const PatchPlace place : {PatchPlace::middle, PatchPlace::random}) {
            Vec3d sum(0.0);
            const std::vector<Lamp> lamps = emitter_lamps(ball, count, place, 0);
            EXPECT_NEAR(double(lamps.size()), double(count), 3);
            for (const Lamp& lamp : lamps) {
                const LampLight light = lamp_light(lamp, Vec3d(0.1, 2, 0));
                sum += Vec3d(lamp.colour) * (pi * light.share * std::max(0.0, -light.direction.y));
            }
            for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c] / exact[c], 1, 0.02) << count << " lamps";
        }
}

}  // namespace
}  // namespace haarfield
