/// Materials of POV-Ray scenes, with POV-Ray as the oracle.

#include <gtest/gtest.h>

#include "bridge/pictures/image_difference.h"
#include "bridge/povray/baked_scene.h"
#include "bridge/povray/povray_process.h"
#include "bridge/povray/reference_scene.h"
#include "shading/bake/ray_renderer.h"
#include "tests/fixtures/bridge_fixtures.h"
#include "tests/fixtures/example_scene.h"

namespace haarfield {
namespace {

Material finish(float diffuse, float phong, float blinn, float metallic) {
    Material material;
    material.convention = LobeConvention::povray;
    material.pigment = Rgb(0.8f, 0.4f, 0.1f);
    material.diffuse = material.pigment * diffuse;
    material.specular = Rgb(1.0f);
    material.phong = phong;
    material.shininess = 12;
    material.blinn = blinn;
    material.roughness = 0.03f;
    material.metallic = metallic;
    return material;
}

/// Each term alone, and all combined.
const std::vector<std::pair<const char*, Material>>& finishes() {
    static const std::vector<std::pair<const char*, Material>> all{
        {"diffuse", finish(0.7f, 0, 0, 0)},
        {"phong", finish(0, 0.5f, 0, 0)},
        {"specular", finish(0, 0, 0.6f, 0)},
        {"metallic phong", finish(0, 0.5f, 0, 1)},
        {"metallic specular", finish(0, 0, 0.6f, 0.7f)},
        {"all", finish(0.5f, 0.2f, 0.3f, 0.6f)}};
    return all;
}

Image picture(const std::filesystem::path& scene, const Camera& camera) {
    PovrayOptions options;
    options.width = camera.width;
    options.height = camera.height;
    options.declarations = {without_background};
    const Result<RenderedScene> rendered = rendered_scene(scene, options);
    EXPECT_TRUE(rendered) << rendered.error().message();
    return rendered ? rendered->image : Image{};
}

/// A plane under one distant light, pixel by pixel.
TEST(Finish, EachTermAndAllTogetherAreWhatPovrayComputes) {
    const int height = 64, sun_row = 26, sun_column = 90;  // low, so that metal fades
    LatLongImage environment = constant_environment(height, Rgb(0, 0, 0));
    const double solid_angle = lat_long_pixel_solid_angle(sun_row, 2 * height, height);
    environment.pixels[std::size_t(sun_row * 2 * height + sun_column)] =
        Rgb(static_cast<float>(1 / solid_angle));
    const Vec3d light = lat_long_direction((sun_column + 0.5) / (2 * height), (sun_row + 0.5) / height);
    ASSERT_GT(light.z, 0.1);
    ASSERT_LT(light.z, 0.4);
    const Mesh mesh = upright_square_mesh(1.1f, 1);
    const float distance = 0.5f;
    const Camera camera = frontal_camera(distance, 40);
    for (const auto& [name, material] : finishes()) {
        const TestFolder folder;
        const ReferenceInstance instance{"square", &mesh, {&material, 1}, {}};
        const Result<ReferenceFiles> files =
            write_reference_scene(folder.path(), "finish", camera, {&instance, 1}, environment, 16);
        ASSERT_TRUE(files) << files.error().message();
        EXPECT_TRUE(files->warnings.empty());
        const Image image = picture(files->scene, camera);
        ASSERT_EQ(image.pixels.size(), 1600u);
        double brightest = 0;
        for (int y = 0; y < 40; ++y)
            for (int x = 0; x < 40; ++x) {
                const Vec3d point((x + 0.5) / 20 - 1, 1 - (y + 0.5) / 20, 0);
                const Vec3d mirror = (Vec3d(0, 0, double(distance)) + point).normalized();
                const Vec3d expected = reflectance(material, Vec3d(0, 0, 1), mirror, light).total();
                const Rgb& found = image.pixels[std::size_t(40 * y + x)];
                for (int c = 0; c < 3; ++c)
                    EXPECT_NEAR(found[c], expected[c], 1e-3 * expected[c] + 1e-6)
                        << name << ", channel " << c << ", pixel " << x << ", " << y;
                brightest = std::max(brightest, expected.x);
            }
        EXPECT_GT(brightest, 0.04) << name;
    }
}

/// A sphere under a sky with a sun, baked and traced by POV-Ray.
TEST(Finish, BakedPicturesEqualPovraysOwn) {
    const Vec3d sun = Vec3d(0.8, 0.5, 0.6).normalized();
    const Camera camera = frontal_camera(4, 32);
    ExampleScene example;
    example.scene.instances.push_back({example.add_entity(sphere_mesh({0, 0, 0}, 0.9f, 48), Material{}), {}});
    example.scene.environment =
        environment([&](const Vec3d& d) { return 0.3 + 0.2 * d.y + 8 * std::exp(30 * (d.dot(sun) - 1)); });
    example.scene.eye = camera.position;
    const Mesh& mesh = example.mesh(0).fine;
    for (const auto& [name, material] : finishes()) {
        example.scene.entities[0].materials = {material};
        const TestFolder folder;
        const ReferenceInstance instance{"ball", &mesh, {&material, 1}, {}};
        const Result<ReferenceFiles> files = write_reference_scene(
            folder.path(), "reference", camera, {&instance, 1}, example.scene.environment, 1000);
        ASSERT_TRUE(files) << files.error().message();
        const Image reference = picture(files->scene, camera);
        for (const auto& [renderer, radiance] :
             {std::pair{"dense", example.dense()}, std::pair{"tree", example.radiance()},
              std::pair{"rays", total(*ray_scene_radiance(example.scene, {1024}))}}) {
            const BakedInstance baked_ball{"ball", &mesh, {}, radiance[0]};
            const Result<BakedFiles> baked =
                write_baked_scene(folder.path(), "baked", camera, {&baked_ball, 1}, {});
            ASSERT_TRUE(baked) << baked.error().message();
            const Result<ImageDifference> difference =
                image_difference(picture(baked->scene, camera), reference);
            ASSERT_TRUE(difference) << difference.error().message();
            EXPECT_LT(difference->relative_rmse, 0.02) << name << ", " << renderer;
            EXPECT_LT(std::abs(difference->bias), 0.005) << name << ", " << renderer;
        }
    }
}

}  // namespace
}  // namespace haarfield
