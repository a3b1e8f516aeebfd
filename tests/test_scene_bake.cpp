#include "scenes/scene_bake.h"

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

}  // namespace
}  // namespace haarfield
