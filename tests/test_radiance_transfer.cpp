#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "shading/light_transfer.h"
#include "shading/lighting.h"
#include "shading/motion_transfer.h"
#include "shading/renderer.h"
#include "shading/view_transfer.h"
#include "tests/example_scene.h"

namespace haarfield {
namespace {

RenderSettings settings() {
    RenderSettings result;
    result.face_size = ExampleScene::size;
    result.occlusion = Occlusion::fields;  // as frames see what moves
    return result;
}

LatLongImage sky(double turn) {
    const Vec3d sun = Vec3d(std::sin(turn), 0.8, std::cos(turn)).normalized();
    LatLongImage image =
        environment([&](const Vec3d& d) { return 0.5 + d.y * 0.3 + 6 * std::exp(20 * (d.dot(sun) - 1)); });
    for (Rgb& pixel : image.pixels) pixel *= Rgb(1, 0.8f, 0.5f);
    return image;
}

/// A floor, two blocks that are looked up in their field, and two balls; all of them rough and glossy.
class Furnished : public ExampleScene {
public:
    Furnished() {
        PreparedMesh floor_mesh = prepared_as_is(square_mesh(5, 0, 10));
        floor_mesh.coarse = square_mesh(5, 0);
        Material lacquer = glossy(30, LobeConvention::povray);
        lacquer.diffuse = Rgb(0.4f, 0.2f, 0.1f);
        lacquer.specular = Rgb(0.3f, 0.3f, 0.2f);
        Material metal = glossy(15, LobeConvention::physical);
        metal.specular = Rgb(0.6f);
        Material brass = lacquer;
        brass.specular = Rgb(1.0f);
        brass.phong = 0.1f;
        brass.blinn = 0.3f;
        brass.metallic = 0.8f;
        brass.pigment = Rgb(0.8f, 0.4f, 0.2f);
        const auto floor = add_entity(floor_mesh, matte(0.6f), 6, 18);
        block = add_entity(box_mesh({-0.4f, 0, -0.4f}, {0.4f, 0.8f, 0.4f}, 4), lacquer, 800, 1200);
        const auto ball = add_entity(sphere_mesh({0, 0.4f, 0}, 0.4f, 10), metal, 500, 800);
        const auto brass_ball = add_entity(sphere_mesh({0, 0.3f, 0}, 0.3f, 8), brass, 500, 800);
        scene.instances = {{floor, {0, 0, 0}, 1},
                           {block, {-0.6f, 0, 0}, 1},
                           {ball, {0.5f, 0, 0.4f}, 1},
                           {block, {0.6f, 0, -0.9f}, 0.7f},
                           {brass_ball, {0.2f, 0, 1.3f}, 1}};
        scene.environment = sky(0.4);
        scene.eye = {2, 2, 3};
    }
    RgbCubemapTree light() const {
        return lighting_tree(scene.environment, size, {settings().light_coefficients});
    }
    const ShadingGeometry& geometry() const {
        if (!geometry_) geometry_ = std::move(*shading_geometry(scene, settings()));
        return *geometry_;
    }
    VertexRadiance full() const { return *vertex_radiance(scene, settings()); }

    std::size_t block;

private:
    mutable std::optional<ShadingGeometry> geometry_;
};

Furnished& furnished() {
    static Furnished scene;
    return scene;
}

double relative_rmse(const VertexRadiance& found, const VertexRadiance& wanted) {
    double error = 0, norm = 0;
    EXPECT_EQ(found.size(), wanted.size());
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        EXPECT_EQ(found[i].size(), wanted[i].size());
        for (std::size_t v = 0; v < wanted[i].size(); ++v) {
            const Vec3f difference = found[i][v] - wanted[i][v];
            error += double(difference.dot(difference));
            norm += double(wanted[i][v].dot(wanted[i][v]));
        }
    }
    return std::sqrt(error / norm);
}

TEST(LightTransfer, UnprunedEqualsTheProductIntegralUnderAnyLight) {
    Furnished scene;
    const LightTransfer transfer = *light_transfer(scene.scene, scene.geometry(), settings(), {0},
                                                   dense_coefficients(scene.light(), scene.size));
    for (const double turn : {0.4, 2.0, 4.0}) {
        scene.scene.environment = sky(turn);
        VertexRadiance found;
        transfer_light(transfer, scene.scene, dense_coefficients(scene.light(), scene.size), found);
        EXPECT_LT(relative_rmse(found, scene.full()), 1e-3) << turn;
    }
}

TEST(LightTransfer, PruningIsWithinTheErrorItIsGiven) {
    Furnished scene;
    std::size_t bytes_before = ~std::size_t(0);
    for (const float error : {0.003f, 0.01f, 0.03f}) {
        scene.scene.environment = sky(0.4);
        const LightTransfer transfer = *light_transfer(scene.scene, scene.geometry(), settings(), {error},
                                                       dense_coefficients(scene.light(), scene.size));
        for (const double turn : {0.4, 3.0}) {
            scene.scene.environment = sky(turn);
            VertexRadiance found;
            transfer_light(transfer, scene.scene, dense_coefficients(scene.light(), scene.size), found);
            EXPECT_LT(relative_rmse(found, scene.full()), 2 * double(error) + 0.002) << error << ", " << turn;
        }
        EXPECT_LT(transfer.bytes(), bytes_before);
        bytes_before = transfer.bytes();
    }
}

TEST(ViewTransfer, FollowsTheEye) {
    Furnished scene;
    const ViewTransfer transfer =
        *view_transfer(scene.scene, scene.geometry(), settings(), {0.003f}, scene.light());
    for (const Vec3f& eye : {Vec3f(2, 2, 3), Vec3f(-3, 1, 0.5f), Vec3f(0, 5, -1)}) {
        scene.scene.eye = eye;
        VertexRadiance found;
        transfer_view(transfer, scene.scene, found);
        EXPECT_LT(relative_rmse(found, scene.full()), 0.01) << eye;
    }
}

TEST(MotionTransfer, FollowsTheInstanceAlongUpAndDown) {
    Furnished scene;
    const MotionTransfer transfer =
        *motion_transfer(scene.scene, scene.geometry(), settings(), {0}, scene.light(), 3);
    for (const Vec3f& place :
         {Vec3f(0.6f, 0, -0.9f), Vec3f(-0.4f, 0, 1.1f), Vec3f(0.2f, 0.9f, 0.3f), Vec3f(40, 0, 0)}) {
        scene.scene.instances[3].translate = place;
        VertexRadiance found;
        ASSERT_TRUE(
            transfer_motion(transfer, scene.scene, scene.geometry(), settings(), FrameQuality::still, found));
        EXPECT_LT(relative_rmse(found, scene.full()), 1e-3) << place;
    }
}

TEST(MotionTransfer, PruningIsWithinTheErrorItIsGiven) {
    Furnished scene;
    const MotionTransfer transfer = *motion_transfer(scene.scene, scene.geometry(), settings(), {0.01f},
                                                     scene.light(), 3),
                         exact = *motion_transfer(scene.scene, scene.geometry(), settings(), {0},
                                                  scene.light(), 3);
    EXPECT_LT(transfer.vectors.bytes() * 2, exact.vectors.bytes());
    for (const Vec3f& place : {Vec3f(0.6f, 0, -0.9f), Vec3f(-0.4f, 0, 1.1f), Vec3f(0.2f, 0.9f, 0.3f)}) {
        scene.scene.instances[3].translate = place;
        VertexRadiance found;
        ASSERT_TRUE(
            transfer_motion(transfer, scene.scene, scene.geometry(), settings(), FrameQuality::still, found));
        EXPECT_LT(relative_rmse(found, scene.full()), 0.02) << place;
    }
}

TEST(MotionTransfer, RefusesWhatIsRasterizedAtTheVertices) {
    const auto result =
        motion_transfer(furnished().scene, furnished().geometry(), settings(), {0}, furnished().light(), 0);
    ASSERT_FALSE(result);
    EXPECT_NE(result.error().message().find("2 triangles"), std::string::npos) << result.error().message();
}

TEST(RadianceTransfer, DoesNotDependOnTheNumberOfThreads) {
    Furnished& scene = furnished();
    const auto frames = [&] {
        const RgbCubemapTree light = scene.light();
        std::array<VertexRadiance, 3> radiance;
        const DenseCoefficients dense = dense_coefficients(light, scene.size);
        transfer_light(*light_transfer(scene.scene, scene.geometry(), settings(), {0.01f}, dense),
                       scene.scene, dense, radiance[0]);
        transfer_view(*view_transfer(scene.scene, scene.geometry(), settings(), {0.01f}, light), scene.scene,
                      radiance[1]);
        EXPECT_TRUE(
            transfer_motion(*motion_transfer(scene.scene, scene.geometry(), settings(), {0.01f}, light, 1),
                            scene.scene, scene.geometry(), settings(), FrameQuality::moving, radiance[2]));
        return radiance;
    };
    std::optional<std::array<VertexRadiance, 3>> wanted;
    for (const std::size_t threads : {1u, 2u, 8u}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        auto found = frames();
        if (!wanted) wanted = found;
        EXPECT_EQ(found, *wanted) << threads;
    }
}

TEST(RadianceTransfer, StopsWhenAsked) {
    std::stop_source stop;
    stop.request_stop();
    const Progress progress{{}, stop.get_token()};
    Furnished& scene = furnished();
    const RgbCubemapTree light = scene.light();
    const auto by_light = light_transfer(scene.scene, scene.geometry(), settings(), {},
                                         dense_coefficients(light, scene.size), progress);
    const auto by_view = view_transfer(scene.scene, scene.geometry(), settings(), {}, light, progress);
    const auto by_motion = motion_transfer(scene.scene, scene.geometry(), settings(), {}, light, 1, progress);
    ASSERT_TRUE(!by_light && !by_view && !by_motion);
    for (const auto& error : {by_light.error(), by_view.error(), by_motion.error()})
        EXPECT_EQ(error.what, interrupted);
}

}  // namespace
}  // namespace haarfield
