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

TEST(SceneBake, ASecondSearchStartsWithMoreVerticesIfTheBudgetAllows) {
    EXPECT_EQ(search_starts({}), (std::vector<std::uint32_t>{10000, 100000}));
    EXPECT_EQ(search_starts(100000), (std::vector<std::uint32_t>{10000, 50000}));
    EXPECT_EQ(search_starts(60000), (std::vector<std::uint32_t>{10000}));
    Scene scene;
    scene.entities.resize(2);
    scene.instances.resize(3);
    scene.entities[0].fine_vertices = 1000;
    scene.entities[1].fine_vertices = 3000;
    scene.instances[2].entity = 1;
    EXPECT_EQ(search_start(scene).entities[1].fine_vertices, 3000u);
    EXPECT_EQ(search_start(scene, 50000).entities[1].fine_vertices, 30000u);
    EXPECT_EQ(search_start(scene, 50000).entities[0].fine_vertices, 10000u);
    scene.entities[1].fine_vertices = 98000;
    EXPECT_EQ(search_start(scene).entities[1].fine_vertices, 9800u);
}

TEST(SceneBake, SearchesAgainWhileASearchStopsEarly) {
    std::vector<std::optional<std::uint32_t>> starts;
    std::vector<bool> stops_early;
    bool is_stopped = true;
    const BakeAttempt attempt = [&](std::optional<std::uint32_t> start,
                                    const BakeOptions& options) -> Result<BakedScene> {
        starts.push_back(start);
        stops_early.push_back(options.stops_early);
        BakedScene baked;
        if (options.error) baked.search.emplace().is_stopped = is_stopped && options.stops_early;
        return baked;
    };
    BakeOptions options;
    ASSERT_TRUE(repeated_bake(options, attempt));
    EXPECT_EQ(starts, (std::vector<std::optional<std::uint32_t>>{std::nullopt}));

    starts.clear();
    stops_early.clear();
    options.error = 0.01;
    EXPECT_FALSE(repeated_bake(options, attempt)->search->is_stopped);
    EXPECT_EQ(starts, (std::vector<std::optional<std::uint32_t>>{10000, 100000}));
    EXPECT_EQ(stops_early, (std::vector<bool>{true, false}));

    starts.clear();
    is_stopped = false;
    ASSERT_TRUE(repeated_bake(options, attempt));
    EXPECT_EQ(starts, (std::vector<std::optional<std::uint32_t>>{10000}));
}

}  // namespace
}  // namespace haarfield
