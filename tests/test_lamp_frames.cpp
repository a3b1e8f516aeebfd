/// Local lights in a session.

#include "shading/transfer/lamp_frames.h"

#include <gtest/gtest.h>

#include "shading/transfer/relight_session.h"
#include "tests/fixtures/example_scene.h"
#include "tests/fixtures/relative_error.h"

namespace haarfield {
namespace {

/// A floor, a glossy box with a knob partly inside it, an emitter, and local lights under a sky.
struct LampLitRoom : ExampleScene {
    LampLitRoom() {
        Material lacquer = glossy(30, LobeConvention::povray);
        lacquer.diffuse = Rgb(0.4f, 0.2f, 0.1f);
        PreparedMesh floor = prepared_as_is(square_mesh(5, 0, 8));
        floor.coarse = square_mesh(5, 0);
        add_entity(floor, matte(0.6f), 6, 18);
        add_entity(joined_meshes(box_mesh({-0.4f, 0, -0.3f}, {0.4f, 0.8f, 0.3f}, 3),
                                 box_mesh({-0.1f, 0.7f, -0.1f}, {0.1f, 0.9f, 0.1f}, 2)),
                   lacquer, 60, 100);
        add_entity(box_mesh({-0.1f, 0, -0.1f}, {0.1f, 0.6f, 0.1f}, 1), matte(0.8f));
        const Mesh& glowing = mesh(2).original;
        for (const auto& [a, b, c] : glowing.triangles)
            scene.entities[2].emitters.push_back(
                {{glowing.positions[a], glowing.positions[b], glowing.positions[c]}, Rgb(1.0f)});
        scene.instances = {{0, {}}, {1, {{-0.8f, 0, 0}, 1}}, {2, {{0.7f, 0.3f, 0.5f}, 1}}};
        scene.environment = environment([](const Vec3d& d) { return 0.2 + 0.1 * d.y; }, 64);
        scene.eye = {2, 2, 3};
        Lamp spot;
        spot.kind = LampKind::spot;
        spot.position = {0.5f, 2, 0.8f};
        spot.target = {-0.8f, 0, 0};
        Lamp bulb;
        bulb.position = {0.7f, 0.6f, 0.5f};
        bulb.colour = Rgb(0.5f, 0.4f, 0.3f);
        bulb.fade_distance = 1;
        bulb.looks_like = 2;
        scene.lamps = {spot, bulb};
        settings.face_size = size;
        settings.exact_triangles = 2;
        settings.occlusion = Occlusion::fields;
    }
    SceneColours fresh_bake(const RelightSession& session) const {
        ShadedScene fresh = session.scene();
        return total(*scene_radiance(fresh, settings));
    }

    RenderSettings settings;
};

TEST(LampFrames, LampsAreDimmedColouredMovedAndSwitchedFromFrameToFrame) {
    const LampLitRoom room;
    RelightSession session(room.scene, room.settings);
    ASSERT_TRUE(session.vary_lamps());
    std::vector<Lamp> lamps = session.lamps();
    const auto frame_equals_a_bake = [&](const char* after) {
        session.set_lamps(lamps);
        ASSERT_TRUE(session.frame()) << after;
        EXPECT_LT(relative_scene_rmse(session.radiance(), room.fresh_bake(session)), 1e-5) << after;
    };
    frame_equals_a_bake("nothing");
    const SceneColours before = session.radiance();
    lamps[0].colour = Rgb(0.1f, 0.5f, 2);
    frame_equals_a_bake("a colour");
    EXPECT_GT(relative_scene_rmse(session.radiance(), before), 0.05);
    lamps[1].colour = Rgb(0.0f);
    frame_equals_a_bake("switching off");
    lamps[0].position = {-1.5f, 1.5f, 1};
    frame_equals_a_bake("moving");
    lamps[1].colour = Rgb(1.0f);
    lamps.push_back(lamps[0]);
    lamps.back().kind = LampKind::parallel;
    frame_equals_a_bake("switching on, and one more");
    lamps.erase(lamps.begin());
    frame_equals_a_bake("taking one away");
    ASSERT_TRUE(session.commit());
    EXPECT_EQ(session.radiance(), room.fresh_bake(session)) << "in all bits";
}

TEST(LampFrames, FollowEachOtherVariableInput) {
    const LampLitRoom room;
    RenderSettings settings = room.settings;
    RelightSession session(room.scene, settings, {0.001f});
    ASSERT_TRUE(session.vary_light());
    ASSERT_TRUE(session.frame());
    EXPECT_LT(relative_scene_rmse(session.radiance(), room.fresh_bake(session)), 0.01);

    ASSERT_TRUE(session.vary_instance(1));
    Placement placement = session.instances()[1].placement;
    placement.translate.z += 0.4f;
    session.place(1, placement);
    ASSERT_TRUE(session.frame());
    EXPECT_LT(relative_scene_rmse(session.radiance(), room.fresh_bake(session)), 0.02);

    ASSERT_TRUE(session.vary_eye());
    session.set_eye({-1, 2, 3});
    ASSERT_TRUE(session.frame());
    EXPECT_LT(relative_scene_rmse(session.radiance(), room.fresh_bake(session)), 0.02);

    // The light's shape then has another instance number, or none.
    session.remove(0);
    EXPECT_EQ(session.lamps()[1].looks_like, 1u);
    session.remove(1);
    EXPECT_FALSE(session.lamps()[1].looks_like);
    ASSERT_TRUE(session.commit());
    EXPECT_EQ(session.radiance(), room.fresh_bake(session));
}

}  // namespace
}  // namespace haarfield
