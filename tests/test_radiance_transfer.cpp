#include <gtest/gtest.h>

#include "fields/base/rotation.h"
#include "shading/transfer/light_transfer.h"
#include "shading/transfer/motion_transfer.h"
#include "shading/transfer/view_transfer.h"
#include "shading/visibility/placed_solids.h"
#include "tests/fixtures/furnished_room.h"
#include "tests/fixtures/with_threads.h"

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

/// The relative RMSE of a transfer's radiance against a bake, which fills vertices inside other instances.
double error_of(SceneColours found, const Room& room) {
    PlacedFill(room.scene)(found);
    return relative_rmse(found, room.full());
}

TEST(LightTransfer, UnprunedEqualsTheProductIntegralUnderAnyLight) {
    Room scene;
    const LightTransfer transfer = *light_transfer(scene.scene, scene.geometry(), settings(), {0},
                                                   dense_coefficients(scene.light(), scene.size));
    for (const double turn : {0.4, 2.0, 4.0}) {
        scene.scene.environment = sky(turn);
        SceneColours found;
        ASSERT_TRUE(shade_frame(transfer, scene.scene, scene.geometry(),
                                dense_coefficients(scene.light(), scene.size), {}, FrameQuality::still,
                                found));
        EXPECT_LT(error_of(found, scene), 2e-3) << turn;  // rounding to bytes
    }
}

TEST(LightTransfer, PruningIsWithinTheGivenError) {
    Room scene;
    std::size_t bytes_before = ~std::size_t(0);
    for (const float error : {0.003f, 0.01f, 0.03f}) {
        scene.scene.environment = sky(0.4);
        const LightTransfer transfer = *light_transfer(scene.scene, scene.geometry(), settings(), {error},
                                                       dense_coefficients(scene.light(), scene.size));
        for (const double turn : {0.4, 3.0}) {
            scene.scene.environment = sky(turn);
            SceneColours found;
            ASSERT_TRUE(shade_frame(transfer, scene.scene, scene.geometry(),
                                    dense_coefficients(scene.light(), scene.size), {}, FrameQuality::still,
                                    found));
            EXPECT_LT(error_of(found, scene), 2 * double(error) + 0.002) << error << ", " << turn;
        }
        EXPECT_LT(transfer.bytes(), bytes_before);
        bytes_before = transfer.bytes();
    }
}

/// A ball, diffuse or also specular, lit by a sky and a small sun.
class SunlitBall : public ExampleScene {
public:
    explicit SunlitBall(float specular) {
        Material material = glossy(6, LobeConvention::povray);
        material.diffuse = Rgb(0.6f);
        material.specular = Rgb(specular);
        scene.instances.push_back({add_entity(sphere_mesh({0, 0, 0}, 1, 12), material), {}});
        scene.eye = {0, 0, 5};
    }
    DenseCoefficients light_with_sun_at(const Vec3d& sun) {
        scene.environment =
            environment([&](const Vec3d& d) { return 0.2 + 3000 * std::exp(9000 * (d.dot(sun) - 1)); }, 512);
        return dense_coefficients(lighting_tree(split_light(scene.environment).smooth, size, {}), size);
    }
};

TEST(LightTransfer, MeetsTheCosineOfASunWhereverItStands) {
    for (const float specular : {0.0f, 0.02f}) {
        SunlitBall ball(specular);
        const DenseCoefficients typical = ball.light_with_sun_at(Vec3d(0.3, 0.7, 0.5).normalized());
        const ShadingGeometry geometry = *shading_geometry(ball.scene, settings());
        const LightTransfer transfer = *light_transfer(ball.scene, geometry, settings(), {0.003f}, typical);
        for (int i = 0; i < 8; ++i) {
            SceneColours found;
            const DenseCoefficients light =
                ball.light_with_sun_at(rotation_about({1, 2, -1}, 0.7 * i)(Vec3d(0, 0.6, 0.8)));
            ASSERT_TRUE(shade_frame(transfer, ball.scene, geometry, light,
                                    all_lights(split_light(ball.scene.environment).sources),
                                    FrameQuality::still, found));
            EXPECT_LT(relative_rmse(found, ball.dense()), 0.0105) << specular << ", " << i;
        }
    }
}

TEST(ViewTransfer, FollowsTheEye) {
    Room scene;
    const ViewTransfer transfer =
        *view_transfer(scene.scene, scene.geometry(), settings(), {0.003f}, scene.light(), {});
    for (const Vec3f& eye : {Vec3f(2, 2, 3), Vec3f(-3, 1, 0.5f), Vec3f(0, 5, -1)}) {
        scene.scene.eye = eye;
        SceneColours found;
        ASSERT_TRUE(shade_frame(transfer, scene.scene, scene.geometry(), found));
        EXPECT_LT(error_of(found, scene), 0.01) << eye;
    }
}

TEST(MotionTransfer, FollowsTheInstanceAlongUpAndDown) {
    Room scene;
    const MotionTransfer transfer =
        *motion_transfer(scene.scene, scene.geometry(), settings(), {0}, scene.light(), {}, 3);
    for (const Vec3f& place :
         {Vec3f(0.6f, 0, -0.9f), Vec3f(-0.4f, 0, 1.1f), Vec3f(0.2f, 0.9f, 0.3f), Vec3f(40, 0, 0)}) {
        scene.scene.instances[3].placement.translate = place;
        SceneColours found;
        ASSERT_TRUE(
            shade_frame(transfer, scene.scene, scene.geometry(), settings(), FrameQuality::still, found));
        // Beyond the field's samples, the occlusion is too large and too faint.
        EXPECT_LT(error_of(found, scene), 3e-3) << place;
    }
}

TEST(MotionTransfer, PruningIsWithinTheGivenError) {
    Room scene;
    const MotionTransfer transfer = *motion_transfer(scene.scene, scene.geometry(), settings(), {0.01f},
                                                     scene.light(), {}, 3),
                         exact = *motion_transfer(scene.scene, scene.geometry(), settings(), {0},
                                                  scene.light(), {}, 3);
    EXPECT_LT(transfer.vectors.bytes() * 2, exact.vectors.bytes());
    for (const Vec3f& place : {Vec3f(0.6f, 0, -0.9f), Vec3f(-0.4f, 0, 1.1f), Vec3f(0.2f, 0.9f, 0.3f)}) {
        scene.scene.instances[3].placement.translate = place;
        SceneColours found;
        ASSERT_TRUE(
            shade_frame(transfer, scene.scene, scene.geometry(), settings(), FrameQuality::still, found));
        EXPECT_LT(error_of(found, scene), 0.02) << place;
    }
}

TEST(RadianceTransfer, DoesNotDependOnTheNumberOfThreads) {
    Room& scene = furnished_room();
    const auto frames = [&] {
        const RgbCubemapTree light = scene.light();
        std::array<SceneColours, 3> radiance;
        const DenseCoefficients dense = dense_coefficients(light, scene.size);
        EXPECT_TRUE(shade_frame(*light_transfer(scene.scene, scene.geometry(), settings(), {0.01f}, dense),
                                scene.scene, scene.geometry(), dense, {}, FrameQuality::still, radiance[0]));
        EXPECT_TRUE(shade_frame(*view_transfer(scene.scene, scene.geometry(), settings(), {0.01f}, light, {}),
                                scene.scene, scene.geometry(), radiance[1]));
        EXPECT_TRUE(
            shade_frame(*motion_transfer(scene.scene, scene.geometry(), settings(), {0.01f}, light, {}, 1),
                        scene.scene, scene.geometry(), settings(), FrameQuality::moving, radiance[2]));
        return radiance;
    };
    std::optional<std::array<SceneColours, 3>> wanted;
    for (const std::size_t threads : {1u, 2u, 8u}) {
        const auto found = with_threads(threads, frames);
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
    const auto by_view = view_transfer(scene.scene, scene.geometry(), settings(), {}, light, {}, progress);
    const auto by_motion =
        motion_transfer(scene.scene, scene.geometry(), settings(), {}, light, {}, 1, progress);
    ASSERT_TRUE(!by_light && !by_view && !by_motion);
    for (const auto& error : {by_light.error(), by_view.error(), by_motion.error()})
        EXPECT_EQ(error.code, ErrorCode::interrupted);
}

}  // namespace
}  // namespace haarfield
