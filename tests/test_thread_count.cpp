#include <gtest/gtest.h>

#include <mutex>
#include <set>

#include "scenes/scene_bake.h"
#include "scenes/scene_environment.h"
#include "scenes/scene_reader.h"
#include "scenes/scene_shading.h"
#include "shading/transfer/relight_session.h"
#include "tests/fixtures/example_scene.h"
#include "tests/fixtures/test_folder.h"
#include "tests/fixtures/with_threads.h"

namespace haarfield {
namespace {

constexpr std::size_t wanted_threads = 3;  // neither one nor, on most machines, one per core

/// Notes the stages of a computation in which the process may not use `wanted_threads` threads.
class ThreadWatch {
public:
    Progress progress() {
        return {[this](std::string_view stage, std::uint64_t, std::uint64_t) { check(stage); }, {}};
    }
    void check(std::string_view stage) {
        ++checks_;
        if (allowed_threads() != wanted_threads) wrong_.emplace(stage);
    }
    std::size_t checks() const { return checks_; }
    const std::set<std::string>& wrong() const { return wrong_; }

private:
    std::size_t checks_ = 0;
    std::set<std::string> wrong_;
};

/// A box with a sheet on top, on a floor, under a sky with a sun, from files.
Scene box_on_a_floor(const TestFolder& folder) {
    write_text(folder / "floor.obj", "v -2 0 -2\nv 2 0 -2\nv 2 0 2\nv -2 0 2\nf 4 3 2 1\n");
    write_text(
        folder / "box.obj",
        "v -.5 0 -.5\nv .5 0 -.5\nv .5 0 .5\nv -.5 0 .5\nv -.5 1 -.5\nv .5 1 -.5\nv .5 1 .5\nv -.5 1 .5\n"
        "v -1 1.2 -1\nv 1 1.2 -1\nv 1 1.2 1\nv -1 1.2 1\n"
        "f 1 2 3 4\nf 8 7 6 5\nf 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 4 8 5 1\nf 12 11 10 9\n");
    write_text(folder / "room.toml",
               "[camera]\nposition = [2.5, 2, 3]\ntarget = [0, 0.4, 0]\n"
               "[environment]\nsky = { turbidity = 3, sun_elevation = 40 }\n"
               "[materials.clay]\ndiffuse = [0.5, 0.4, 0.3]\nspecular = [0.2, 0.2, 0.2]\n"
               "[entities.floor]\nmesh = \"floor.obj\"\nmaterial = \"clay\"\nfine_vertices = 60\n"
               "[entities.box]\nmesh = \"box.obj\"\nmaterial = \"clay\"\nfine_vertices = 90\n"
               "planar_samples = 30\nspherical_samples = 30\n"
               "[[instances]]\nentity = \"floor\"\n"
               "[[instances]]\nentity = \"box\"\nrotate = [0, 20, 0]\n"
               "[[instances]]\nentity = \"box\"\ntranslate = [1.2, 0, 0.3]\nscale = 0.5\n");
    return *read_scene(folder / "room.toml");
}

TEST(ThreadCount, IsRespectedByEveryComputation) {
    const TestFolder folder;
    const Scene scene = box_on_a_floor(folder);
    with_threads(wanted_threads, [&] {
        ThreadWatch watch;
        SceneEntityOptions options;
        options.fields_folder = folder / "fields";
        RenderSettings settings;
        options.face_size = settings.face_size = 16;
        settings.bounces.most = 2;
        const SceneEntities entities = *prepare_scene_entities(scene, options, watch.progress());
        watch.check("after precompute");
        const ShadedScene shaded = shaded_scene(scene, entities, scene_environment(scene)->environment);
        BakeOptions baking;
        EXPECT_TRUE(baked_scene(scene, entities, shaded, settings, baking, watch.progress()));
        watch.check("after a bake");
        baking.refine = 0.05f;
        baking.colours = BakedColours::fitted;
        EXPECT_TRUE(baked_scene(scene, entities, shaded, settings, baking, watch.progress()));
        watch.check("after refinement");

        RelightSession session(shaded, settings, {});
        for (const bool separates : {false, true}) {
            session.separate_components(separates);
            EXPECT_TRUE(session.prepare(watch.progress()));
            EXPECT_TRUE(session.vary_light(watch.progress()));
            EXPECT_TRUE(session.frame(FrameQuality::still, watch.progress()));
            EXPECT_TRUE(session.vary_eye(watch.progress()));
            EXPECT_TRUE(session.frame(FrameQuality::still, watch.progress()));
            EXPECT_TRUE(session.vary_instance(1, watch.progress()));
            EXPECT_TRUE(session.frame(FrameQuality::moving, watch.progress()));
            EXPECT_TRUE(session.commit(watch.progress()));
            watch.check("after frames of a session");
        }
        EXPECT_GT(watch.checks(), 20u);
        EXPECT_EQ(watch.wrong(), std::set<std::string>());
    });
}

/// Enough triangles for Embree to build in parallel; every one twice, and faces that share a plane with the
/// floor and with those of the next instance.
SceneColours radiance_of_equal_surfaces() {
    ExampleScene example;
    const Mesh ball = sphere_mesh({0, 0.4f, 0}, 0.4f, 26),
               box = box_mesh({-0.5f, 0, -0.5f}, {0.5f, 0.7f, 0.5f}, 5);
    const auto floor = example.add_entity(joined_meshes(square_mesh(4, 0, 12), square_mesh(3, 0, 12)),
                                          matte(0.7f)),
               twice = example.add_entity(joined_meshes(joined_meshes(ball, ball), joined_meshes(box, box)),
                                          matte(0.5f), 60, 60);
    example.scene.instances = {{floor, {}}, {twice, {}}, {twice, {{1, 0, 0}, 1}}, {twice, {{1, 0, 0}, 1}}};
    example.scene.environment = environment([](const Vec3d& d) {
        return 0.3 + 60 * std::pow(std::max(0.0, d.dot(Vec3d(0.4, 0.8, 0.45).normalized())), 300);
    });
    RenderSettings settings;
    settings.face_size = ExampleScene::size;
    settings.bounces.most = 2;
    return total(*scene_radiance(example.scene, settings));
}

TEST(ThreadCount, ChangesNothingWhereSurfacesCoincide) {
    const SceneColours wanted = with_threads(1, radiance_of_equal_surfaces);
    for (const std::size_t threads : {2u, 8u})
        EXPECT_TRUE(with_threads(threads, radiance_of_equal_surfaces) == wanted) << threads;
}

}  // namespace
}  // namespace haarfield
