#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "shading/light_transfer.h"
#include "shading/motion_transfer.h"
#include "shading/view_transfer.h"
#include "tests/furnished_room.h"

namespace haarfield {
namespace {

using furnished::relative_rmse;
using furnished::Room;
using furnished::settings;
using furnished::sky;

Room& furnished_room() {
    static Room scene;
    return scene;
}

TEST(LightTransfer, UnprunedEqualsTheProductIntegralUnderAnyLight) {
    Room scene;
    const LightTransfer transfer = *light_transfer(scene.scene, scene.geometry(), settings(), {0},
                                                   dense_coefficients(scene.light(), scene.size));
    for (const double turn : {0.4, 2.0, 4.0}) {
        scene.scene.environment = sky(turn);
        VertexRadiance found;
        ASSERT_TRUE(transfer_light(transfer, scene.scene, scene.geometry(),
                                   dense_coefficients(scene.light(), scene.size), found));
        EXPECT_LT(relative_rmse(found, scene.full()), 2e-3) << turn;  // rounding to bytes
    }
}

TEST(LightTransfer, PruningIsWithinTheErrorItIsGiven) {
    Room scene;
    std::size_t bytes_before = ~std::size_t(0);
    for (const float error : {0.003f, 0.01f, 0.03f}) {
        scene.scene.environment = sky(0.4);
        const LightTransfer transfer = *light_transfer(scene.scene, scene.geometry(), settings(), {error},
                                                       dense_coefficients(scene.light(), scene.size));
        for (const double turn : {0.4, 3.0}) {
            scene.scene.environment = sky(turn);
            VertexRadiance found;
            ASSERT_TRUE(transfer_light(transfer, scene.scene, scene.geometry(),
                                       dense_coefficients(scene.light(), scene.size), found));
            EXPECT_LT(relative_rmse(found, scene.full()), 2 * double(error) + 0.002) << error << ", " << turn;
        }
        EXPECT_LT(transfer.bytes(), bytes_before);
        bytes_before = transfer.bytes();
    }
}

TEST(ViewTransfer, FollowsTheEye) {
    Room scene;
    const ViewTransfer transfer =
        *view_transfer(scene.scene, scene.geometry(), settings(), {0.003f}, scene.light());
    for (const Vec3f& eye : {Vec3f(2, 2, 3), Vec3f(-3, 1, 0.5f), Vec3f(0, 5, -1)}) {
        scene.scene.eye = eye;
        VertexRadiance found;
        ASSERT_TRUE(transfer_view(transfer, scene.scene, scene.geometry(), found));
        EXPECT_LT(relative_rmse(found, scene.full()), 0.01) << eye;
    }
}

TEST(MotionTransfer, FollowsTheInstanceAlongUpAndDown) {
    Room scene;
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
    Room scene;
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
    const auto result = motion_transfer(furnished_room().scene, furnished_room().geometry(), settings(), {0},
                                        furnished_room().light(), 0);
    ASSERT_FALSE(result);
    EXPECT_NE(result.error().message().find("2 triangles"), std::string::npos) << result.error().message();
}

TEST(RadianceTransfer, DoesNotDependOnTheNumberOfThreads) {
    Room& scene = furnished_room();
    const auto frames = [&] {
        const RgbCubemapTree light = scene.light();
        std::array<VertexRadiance, 3> radiance;
        const DenseCoefficients dense = dense_coefficients(light, scene.size);
        EXPECT_TRUE(transfer_light(*light_transfer(scene.scene, scene.geometry(), settings(), {0.01f}, dense),
                                   scene.scene, scene.geometry(), dense, radiance[0]));
        EXPECT_TRUE(transfer_view(*view_transfer(scene.scene, scene.geometry(), settings(), {0.01f}, light),
                                  scene.scene, scene.geometry(), radiance[1]));
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
    Room& scene = furnished_room();
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
