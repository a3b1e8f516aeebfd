#include "scenes/session_scene.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "shading/scene/sky.h"

namespace haarfield {
namespace {

/// A stool on a floor, as files.
class SessionSceneTest : public testing::TestWithParam<Occlusion> {
protected:
    void SetUp() override {
        folder =
            std::filesystem::temp_directory_path() / ("haarfield_session_scene_" + std::to_string(getpid()));
        std::filesystem::remove_all(folder);
        std::filesystem::create_directories(folder);
        std::ofstream(folder / "floor.obj") << "v -3 0 -3\nv -3 0 3\nv 3 0 3\nv 3 0 -3\nf 1 2 3 4\n";
        std::ofstream stool(folder / "stool.obj");
        write_box(stool, 0, -0.3, 0.4, -0.3, 0.3, 0.5, 0.3);
        write_box(stool, 8, -0.1, 0, -0.2, 0.2, 0.4, 0.1);
        stool.close();
        for (const char* name : {"floor", "stool"}) {
            Entity entity;
            entity.name = name;
            entity.mesh = folder / (std::string(name) + ".obj");
            entity.material = "paint";
            entity.fine_vertices = 300;
            entity.coarse_triangles = 0;
            entity.planar_samples = 100;
            entity.spherical_samples = 150;
            scene.entities.push_back(entity);
        }
        scene.materials["paint"].specular = Rgb(0.2f);
        scene.instances = {{"floor", 0, {}, {0, 0, 0}},
                           {"stool_1", 1, {}, {0, 0, 0}},
                           {"stool_2", 1, {{1, 0, 0.4f}, 1}, {0, 0.6f, 0}}};
        scene.camera.position = {2, 2, 3};
        options.fields_folder = folder / "fields";
        options.face_size = 16;
        settings.face_size = 16;
        settings.exact_triangles = 2;
        settings.occlusion = GetParam();
    }
    void TearDown() override { std::filesystem::remove_all(folder); }

    static void write_box(std::ostream& file, int before, double x0, double y0, double z0, double x1,
                          double y1, double z1) {
        for (int i = 0; i < 8; ++i)
            file << "v " << (i & 1 ? x1 : x0) << ' ' << (i & 2 ? y1 : y0) << ' ' << (i & 4 ? z1 : z0) << '\n';
        for (const auto& face : {std::array{1, 5, 7, 3}, std::array{2, 4, 8, 6}, std::array{1, 2, 6, 5},
                                 std::array{3, 7, 8, 4}, std::array{1, 3, 4, 2}, std::array{5, 6, 8, 7}}) {
            file << 'f';
            for (const int corner : face) file << ' ' << corner + before;
            file << '\n';
        }
    }

    std::filesystem::path folder;
    Scene scene;
    SceneEntityOptions options;
    RenderSettings settings;
};

INSTANTIATE_TEST_SUITE_P(Occlusion, SessionSceneTest,
                         testing::Values(Occlusion::fields, Occlusion::automatic), [](const auto& test) {
                             return test.param == Occlusion::fields ? "Fields" : "Automatic";
                         });

TEST_P(SessionSceneTest, ATurnedAndMovedSceneEqualsABakeOfItsFile) {
    const LatLongImage sky = sky_image({}, 128);
    const auto entities = prepare_scene_entities(scene, options);
    ASSERT_TRUE(entities) << entities.error().message();
    RelightSession session(session_scene(scene, *entities, sky), settings);
    ASSERT_TRUE(session.rotate(1, {0, 1, 0}, 0.5));
    ASSERT_TRUE(session.rotate(1, {1, 0, 0.3}, -0.4));
    ASSERT_TRUE(session.rotate(2, {0, 0, 1}, 0.2));
    session.place(1, {{-0.8f, 0.1f, 0.2f}, 1.3f});
    const std::size_t third = session.clone(2);
    session.place(third, {{0.2f, 0, -1.2f}, 0.8f});
    ASSERT_TRUE(session.commit());

    Scene written = scene;
    written.instances.clear();
    for (const SessionInstance& instance : session.instances())
        written.instances.push_back({"", instance.entity, instance.placement, instance.rotate});
    const auto fresh = prepare_scene_entities(written, options);
    ASSERT_TRUE(fresh) << fresh.error().message();
    const auto baked = scene_radiance(shaded_scene(written, *fresh, sky), settings);
    ASSERT_TRUE(baked);
    ASSERT_EQ(baked->size(), session.radiance().size());
    for (std::size_t i = 0; i < baked->size(); ++i) {
        ASSERT_EQ((*baked)[i].size(), session.radiance()[i].size());
        for (std::size_t v = 0; v < (*baked)[i].size(); ++v)
            for (int c = 0; c < 3; ++c)
                ASSERT_NEAR(session.radiance()[i][v][c], (*baked)[i][v][c], 1e-4f * (1 + (*baked)[i][v][c]))
                    << i << ", " << v;
    }
}

TEST_P(SessionSceneTest, OpensWithTheTurnsOfTheFile) {
    const auto entities = prepare_scene_entities(scene, options);
    ASSERT_TRUE(entities);
    RelightSession session(session_scene(scene, *entities, sky_image({}, 128)), settings);
    EXPECT_EQ(session.instances()[2].rotate, scene.instances[2].rotate);
    EXPECT_EQ(session.eye(), scene.camera.position);
    ASSERT_TRUE(session.commit());
    const auto baked = scene_radiance(shaded_scene(scene, *entities, sky_image({}, 128)), settings);
    EXPECT_EQ(session.radiance(), *baked);
}

}  // namespace
}  // namespace haarfield
