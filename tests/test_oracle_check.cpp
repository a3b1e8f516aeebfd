#include "bridge/pictures/oracle_check.h"

#include "bridge/povray/reference_scene.h"
#include "tests/fixtures/bridge_fixtures.h"
#include "tests/fixtures/example_scene.h"

namespace haarfield {
namespace {

/// A ball on a floor, rendered by the oracle and by POV-Ray.
TEST(OracleCheck, AgreesWithPovrayAndDetectsDisagreement) {
    ExampleScene example;
    example.scene.instances = {
        {example.add_entity(square_mesh(6, 0), matte(0.6f)), {}},
        {example.add_entity(sphere_mesh({0, 0.6f, 0}, 0.5f, 24), matte(0.5f)), {{0.1f, 0, 0}, 1}}};
    example.scene.environment = environment([](const Vec3d& d) {
        return 0.5 + 0.3 * d.y + 2 * std::exp(8 * (d.dot(Vec3d(0.6, 0.7, 0.39)) - 1));
    });
    Camera camera;
    camera.position = example.scene.eye = {1.5f, 1.2f, 2};
    camera.target = {0, 0.3f, 0};
    camera.width = camera.height = 48;

    const TestFolder folder;
    std::vector<ReferenceInstance> instances;
    for (const char* name : {"floor", "ball"}) {
        const ShadedInstance& instance = example.scene.instances[instances.size()];
        const ShadedEntity& entity = example.scene.entities[instance.entity];
        instances.push_back({name, entity.mesh, entity.materials, instance.placement});
    }
    const Result<ReferenceFiles> files =
        write_reference_scene(folder.path(), "check", camera, instances, example.scene.environment, 512);
    ASSERT_TRUE(files) << files.error().message();
    PovrayOptions options;
    options.width = camera.width;
    options.height = camera.height;
    const Result<ReferencePicture> picture = rendered_reference(*files, options);
    ASSERT_TRUE(picture) << picture.error().message();

    const Result<OracleCheck> right = oracle_check(example.scene, camera, *picture, 128, 200);
    ASSERT_TRUE(right);
    EXPECT_EQ(right->points, 200u);
    EXPECT_GE(right->agreeing, 190u);
    EXPECT_LT(right->relative_rmse, 0.02);
    EXPECT_LT(std::abs(right->bias), 0.005);

    for (ShadedEntity& entity : example.scene.entities) entity.materials[0].diffuse *= 1.1f;
    const Result<OracleCheck> wrong = oracle_check(example.scene, camera, *picture, 128, 200);
    ASSERT_TRUE(wrong);
    EXPECT_LT(wrong->agreeing, 20u);
    EXPECT_NEAR(wrong->bias, 0.1, 0.01);
}

}  // namespace
}  // namespace haarfield
