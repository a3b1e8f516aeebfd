#include <gtest/gtest.h>

#include "shading/bake/renderer.h"
#include "shading/visibility/shading_geometry.h"
#include "tests/fixtures/example_scene.h"

namespace haarfield {
namespace {

/// Returns a floor with six objects, each a sphere of 3,000 triangles on six thin legs. Half of them are
/// rotated.
ExampleScene crowd() {
    ExampleScene example;
    example.add_entity(square_mesh(6, 0, 12), matte(0.6f));
    Mesh spindles = sphere_mesh({0, 0.75f, 0}, 0.25f, 40);
    for (int k = 0; k < 6; ++k) {
        const float angle = float(k) * float(pi) / 3;
        Mesh leg = sphere_mesh({0, 0, 0}, 1, 16);
        for (Vec3f& p : leg.positions)
            p = Vec3f(0.2f * std::cos(angle), 0.45f, 0.2f * std::sin(angle)) +
                Vec3f(0.03f * p.x, 0.44f * p.y, 0.03f * p.z);
        spindles = joined_meshes(spindles, leg);
    }
    example.add_entity(spindles, matte(0.5f), 300, 400);
    example.scene.instances.push_back({0, {}});
    for (int k = 0; k < 6; ++k)
        example.scene.instances.push_back({1,
                                           {{0.8f * float(k % 3) - 0.8f, 0, 0.9f * float(k / 3) - 0.4f},
                                            1,
                                            k % 2 ? rotation_about({0, 1, 0}, 0.4 * k) : Rotation()}});
    example.scene.environment = environment(
        [](const Vec3d& d) { return 0.4 + 3 * std::exp(8 * (d.x * 0.6 + d.y * 0.7 + d.z * 0.4 - 1)); });
    return example;
}

TEST(OccluderLevels, SimplifiedOccludersCastTheShadowsOfTheOriginals) {
    const ExampleScene example = crowd();
    RenderSettings wanted;
    wanted.face_size = ExampleScene::size;
    wanted.light_coefficients = 0;
    wanted.occlusion = Occlusion::exact;
    wanted.exact_triangles = 0;
    wanted.occlusion_error = 0;  // No instance is interpolated.
    const SceneColours exact = total(*scene_radiance(example.scene, wanted));
    wanted.occlusion = Occlusion::automatic;
    const ShadingGeometry geometry = *shading_geometry(example.scene, wanted);
    ASSERT_TRUE(geometry.entities[1].levels);
    EXPECT_GE(geometry.entities[1].levels->size(), 2u);
    ShadingPoint far;
    far.outside = {-3, 0, 0};
    EXPECT_LT(occluder_for(example.scene, geometry, 3, far).triangles().size(),
              example.scene.entities[1].occlusion->coarse().triangles().size() / 8);
    far.outside = geometry.instances[3].middle;
    EXPECT_EQ(&occluder_for(example.scene, geometry, 3, far), &example.scene.entities[1].occlusion->coarse());

    const SceneColours found = total(*scene_radiance(example.scene, wanted));
    double squares = 0, sum = 0;
    std::size_t different = 0;
    for (std::size_t i = 0; i < exact.size(); ++i)
        for (std::size_t v = 0; v < exact[i].size(); ++v) {
            squares += double((found[i][v] - exact[i][v]).length2());
            sum += double(exact[i][v].length2());
            different += found[i][v] != exact[i][v];
        }
    EXPECT_GT(different, 100u);
    EXPECT_LT(std::sqrt(squares / sum), 0.001);
}

}  // namespace
}  // namespace haarfield
