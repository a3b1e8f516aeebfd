#include <gtest/gtest.h>

#include "shading/bake/renderer.h"
#include "shading/scene/lighting.h"
#include "shading/transfer/relight_session.h"
#include "tests/fixtures/furnished_room.h"

namespace haarfield {
namespace {

Mesh floor_mesh() {
    return square_mesh(5, 0, 6);
}

/// Returns an asymmetric mesh, with one part inside another.
Mesh stool_mesh() {
    return joined_meshes(box_mesh({-0.4f, 0.3f, -0.2f}, {0.3f, 0.5f, 0.3f}, 2),
                         box_mesh({0.1f, 0, 0}, {0.25f, 0.4f, 0.15f}, 2));
}

/// The scene, and for oracles the same scene with rotated meshes instead of rotated instances.
struct TurnedScene {
    ExampleScene turned, plain;

    TurnedScene() {
        PreparedMesh floor = prepared_as_is(floor_mesh());
        floor.coarse = square_mesh(5, 0);
        const PreparedMesh stool = prepared_as_is(stool_mesh());
        Material lacquer = glossy(20, LobeConvention::povray);
        lacquer.diffuse = Rgb(0.4f, 0.2f, 0.1f);
        lacquer.specular = Rgb(0.2f);
        turned.add_entity(floor, matte(0.7f), 6, 18);
        turned.add_entity(stool, lacquer, 300, 400);
        const auto add = [&](std::size_t entity, const Placement& placement) {
            turned.scene.instances.push_back({entity, placement});
            const std::size_t added =
                plain.add_entity(turned_mesh(turned.mesh(entity), placement.rotate),
                                 turned.scene.entities[entity].materials[0], entity == 0 ? 6 : 300, 18);
            plain.scene.instances.push_back({added, {placement.translate, placement.scale}});
        };
        add(0, {{0, 0, 0}, 1, rotation_about({0, 1, 0}, 0.5)});
        add(1, {{0.2f, 0, 0.1f}, 1, rotation_about({0, 1, 0}, 1.1)});
        add(1, {{-0.9f, 0.4f, 0.3f}, 1.3f, rotation_xyz({0.4f, -0.8f, 1.2f})});
        add(1, {{0.9f, 0, -0.6f}, 0.8f});
        for (ExampleScene* example : {&turned, &plain}) {
            example->scene.environment = environment([](const Vec3d& d) {
                return 0.4 + 2 * std::exp(6 * (d.x * 0.6 + d.y * 0.7 + d.z * 0.4 - 1));
            });
            example->scene.eye = {2, 2, 3};
        }
    }
};

const TurnedScene& scenes() {
    static const TurnedScene made;
    return made;
}

RenderSettings settings(std::uint32_t exact_triangles) {
    RenderSettings settings;
    settings.face_size = ExampleScene::size;
    settings.light_coefficients = 0;
    settings.occlusion = Occlusion::exact;
    settings.exact_triangles = exact_triangles;
    return settings;
}

/// Expects nearly equal values. A few vertices may differ, because the rotation moves a sample point next to
/// an edge to its other side.
void expect_near(const SceneColours& found, const SceneColours& wanted, float tolerance) {
    ASSERT_EQ(found.size(), wanted.size());
    std::size_t count = 0, different = 0;
    for (std::size_t i = 0; i < wanted.size(); ++i)
        for (std::size_t v = 0; v < wanted[i].size(); ++v, ++count)
            different += (found[i][v] - wanted[i][v]).length() > tolerance * (1 + wanted[i][v].length());
    EXPECT_LE(different, count / 100);
    EXPECT_GT(count, 300u);
}

TEST(TurnedInstances, EqualRotatedMeshesForTheOracle) {
    expect_near(scenes().turned.dense(), scenes().plain.dense(), 1e-3f);
}

TEST(TurnedInstances, AreShadedAsTheOracleShadesThem) {
    const SceneColours wanted = scenes().plain.dense();
    for (const std::uint32_t exact_triangles : {2u, 1000u})
        expect_near(total(*scene_radiance(scenes().turned.scene, settings(exact_triangles))), wanted, 4e-3f);
}

TEST(TurnedInstances, PointsAreShadedAsVertices) {
    const ShadedScene& scene = scenes().turned.scene;
    const RenderSettings exact = settings(2);
    const ShadingGeometry geometry = *shading_geometry(scene, exact);
    const SceneLight light = scene_light(scene.environment, exact);
    const SceneColours wanted = total(*scene_radiance({scene, geometry, light, exact}));
    std::vector<InstancePoint> points;
    std::vector<Rgb> of_vertices;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const ShadedEntity& entity = scene.entities[scene.instances[i].entity];
        for (std::uint32_t v = 0; v < wanted[i].size(); ++v) {
            if (entity.occlusion->samples().buried[v]) continue;
            points.push_back({i, surface_point(entity, v)});
            of_vertices.push_back(wanted[i][v]);
        }
    }
    const std::vector<Rgb> found = total({*point_radiance({scene, geometry, light, exact}, points)})[0];
    for (std::size_t k = 0; k < found.size(); ++k)
        EXPECT_LT((found[k] - of_vertices[k]).length(), 3e-3f) << points[k].instance;
}

TEST(TurnedInstances, FramesFollowEachVariableInput) {
    RelightSession session(scenes().turned.scene, settings(2), {0.003f});
    const auto expect_frame_as_commit = [&](const char* what, double tolerance) {
        ASSERT_TRUE(session.frame()) << what;
        const SceneColours frame = session.radiance();
        ASSERT_TRUE(session.commit());
        EXPECT_LT(furnished::relative_rmse(frame, session.radiance()), tolerance) << what;
    };
    ASSERT_TRUE(session.vary_light());
    session.turn_environment(rotation_about({0, 1, 0}, 1.3));
    expect_frame_as_commit("light", 0.012);
    ASSERT_TRUE(session.vary_eye());
    session.set_eye({-3, 1, 1});
    expect_frame_as_commit("eye", 0.012);
    // Frames use the samples around the instance, which are sparse here.
    ASSERT_TRUE(session.vary_instance(2));
    session.place(2, {{-1.2f, 0.5f, 0.5f}, 1.2f, session.instances()[2].placement.rotate});
    expect_frame_as_commit("a turned instance", 0.04);
    // The instance has so few triangles that its field has no samples.
    RelightSession cones(scenes().turned.scene, settings(1000), {0.003f});
    ASSERT_TRUE(cones.vary_instance(3));
    cones.place(3, {{0.7f, 0.1f, -0.9f}, 0.7f});
    ASSERT_TRUE(cones.frame());
    const SceneColours frame = cones.radiance();
    ASSERT_TRUE(cones.commit());
    expect_near(frame, cones.radiance(), 0.02f);
}

}  // namespace
}  // namespace haarfield
