#include "scenes/scene_bake.h"

#include "scenes/bake_search.h"
#include "tests/fixtures/example_meshes.h"

#include <gtest/gtest.h>

namespace haarfield {
namespace {

SceneEntities spheres(int segments, std::size_t instances) {
    SceneEntities entities;
    entities.entities.push_back(std::make_unique<SceneEntity>());
    entities.entities[0]->mesh = prepared_as_is(sphere_mesh({0, 0, 0}, 1, segments));
    entities.entity_of_instance.assign(instances, 0);
    return entities;
}

TEST(SceneBake, ARefinementMayHaveOneAndAHalfTimesTheVerticesOfTheModels) {
    EXPECT_EQ(usual_vertex_budget(spheres(8, 2)), RefinementSettings().vertex_budget);
    const SceneEntities fine = spheres(240, 3);
    const std::size_t own = 3 * visible_surface(fine.entities[0]->mesh).positions.size();
    ASSERT_GT(own, 40000u);
    EXPECT_EQ(usual_vertex_budget(fine), own + own / 2);
}

TEST(SceneBake, ASearchMayHaveTheVerticesThatTheSceneAsksForButAtLeast200000) {
    Scene scene;
    scene.entities.resize(1);
    scene.instances.resize(2);
    scene.entities[0].fine_vertices = 1000;
    EXPECT_EQ(search_budget(scene, spheres(8, 2)), 200000u);
    scene.entities[0].fine_vertices = 150000;
    EXPECT_EQ(search_budget(scene, spheres(8, 2)), 300000u);
}

}  // namespace
}  // namespace haarfield
