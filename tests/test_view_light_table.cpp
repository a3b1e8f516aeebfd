#include "tools/view/light_table.h"

#include <gtest/gtest.h>

#include "scenes/scene_environment.h"

namespace haarfield {
namespace {

/// A page may mix and rotate two lights. Their exposure must be that of a bake of the scene.
TEST(LightTable, FindsTheExposureOfAMixtureWithLampsAsBakesDo) {
    Design design;
    EnvironmentDescription& light = design.scene.environment;
    light.sky = AnalyticSky();
    light.exposure.reset();
    BlendedLight other;
    other.sky = AnalyticSky();
    other.sky->sun_elevation = 0.1f;
    other.sky->sun_azimuth = 2.5f;
    LightTable table{RenderSettings()};
    const auto expect_as_baked = [&](const char* of) {
        ++design.light_stamp;
        ASSERT_TRUE(table.take(design));
        const Result<SceneEnvironment> baked = scene_environment(design.scene);
        ASSERT_TRUE(baked) << baked.error().message();
        EXPECT_NEAR(table.exposure(design), baked->exposure, 0.02) << of;
    };
    expect_as_baked("one light");
    light.blend = other;
    for (const float share : {0.0f, 0.3f, 0.5f, 1.0f}) {
        light.blend->share = share;
        expect_as_baked("a mixture");
    }
    light.blend->share = 0.5f;
    light.turn = rotation_about({1, 0.2, 0}, 1.2);
    expect_as_baked("a turned mixture");
    SceneLamp lamp;
    lamp.position = {0, 3, 0};
    lamp.colour = Rgb(0.6f);
    design.scene.lamps.push_back(lamp);
    expect_as_baked("a turned mixture, with a lamp");
    light.blend.reset();
    expect_as_baked("one turned light, with a lamp");
}

}  // namespace
}  // namespace haarfield
