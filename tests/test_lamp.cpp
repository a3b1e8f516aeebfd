/// Local lights, with POV-Ray as the oracle.

#include "shading/scene/lamp.h"

#include <gtest/gtest.h>

#include "bridge/povray/povray_process.h"
#include "bridge/povray/reference_scene.h"
#include "shading/bake/lamp_light.h"
#include "tests/fixtures/bridge_fixtures.h"
#include "tests/fixtures/example_scene.h"

namespace haarfield {
namespace {

constexpr int side = 40;  ///< Side of the pictures: 1,600 points.

Lamp lamp_at(LampKind kind, const Vec3f& position, const Vec3f& target) {
    Lamp lamp;
    lamp.kind = kind;
    lamp.position = position;
    lamp.target = target;
    lamp.colour = Rgb(0.9f, 0.6f, 0.3f);
    return lamp;
}

Lamp with_area(Lamp lamp, std::uint32_t columns, std::uint32_t rows) {
    lamp.area.emplace();
    lamp.area->across = Vec3f(0.5f, 0.1f, 0);
    lamp.area->along = Vec3f(0, 0.4f, 0.3f);
    lamp.area->columns = columns;
    lamp.area->rows = rows;
    return lamp;
}

/// Returns each kind of light with its parameters.
std::vector<std::pair<std::string, Lamp>> lamps() {
    const Vec3f place(-1.6f, 0.5f, 1.2f), middle(0.1f, -0.1f, 0), near(-0.3f, 0.2f, 0.5f);
    std::vector<std::pair<std::string, Lamp>> all;
    const auto add = [&](const char* name, const Lamp& lamp) { all.emplace_back(name, lamp); };
    Lamp lamp = lamp_at(LampKind::point, place, middle);
    add("point", lamp);
    lamp.fade_distance = 0.8f;
    add("point, inverse square", lamp);
    lamp.fade_power = 1.5f;
    lamp.position = near;
    add("point, fade power 1.5, near", lamp);
    lamp = lamp_at(LampKind::spot, place, middle);
    lamp.radius = 0.12f;
    lamp.falloff = 0.4f;
    add("spot", lamp);
    lamp.tightness = 10;
    lamp.falloff = 1.2f;
    lamp.fade_distance = 2;
    add("spot, tight and fading", lamp);
    lamp = lamp_at(LampKind::cylinder, place, middle);
    lamp.radius = 0.3f;
    lamp.falloff = 0.9f;
    add("cylinder", lamp);
    lamp.tightness = 3;
    lamp.fade_distance = 1.5f;
    add("cylinder, tight and fading", lamp);
    lamp = lamp_at(LampKind::parallel, place, middle);
    add("parallel", lamp);
    lamp.fade_distance = 1;
    add("parallel, fading", lamp);
    lamp.position = Vec3f(0.8f, 0, -0.1f);  // its plane intersects the wall
    lamp.target = Vec3f(1.3f, 0.2f, -0.6f);
    add("parallel, from behind", lamp);
    add("area of 4 x 4", with_area(lamp_at(LampKind::point, place, middle), 4, 4));
    add("area of 5 x 3", with_area(lamp_at(LampKind::point, place, middle), 5, 3));
    add("area of 6 x 1", with_area(lamp_at(LampKind::point, place, middle), 6, 1));
    lamp = with_area(lamp_at(LampKind::spot, place, middle), 5, 5);
    lamp.area->circular = true;
    lamp.fade_distance = 1;
    add("circular area, spot", lamp);
    lamp = with_area(lamp_at(LampKind::point, place, middle), 8, 8);
    lamp.area->across = Vec3f(0.5f, 0, 0);
    lamp.area->along = Vec3f(0, 0, 0.5f);
    lamp.area->circular = lamp.area->orient = true;
    add("oriented area", lamp);
    lamp.position = Vec3f(0.05f, 0.05f, 1.5f);
    add("oriented area, level", lamp);
    lamp = with_area(lamp_at(LampKind::point, place, middle), 3, 3);
    lamp.area->illumination = true;
    lamp.fade_distance = 0.5f;
    add("area that illuminates", lamp);
    lamp = lamp_at(LampKind::point, place, middle);
    lamp.shadowless = true;
    add("shadowless", lamp);
    return all;
}

Material finish() {
    Material material;
    material.convention = LobeConvention::povray;
    material.pigment = Rgb(0.8f, 0.5f, 0.4f);
    material.diffuse = material.pigment * 0.6f;
    material.specular = Rgb(1.0f);
    material.phong = 0.2f;
    material.shininess = 12;
    material.blinn = 0.15f;
    material.roughness = 0.05f;
    return material;
}

/// A wall, and a post outside the picture that casts its shadow into it.
struct WallAndPost : ExampleScene {
    explicit WallAndPost(bool has_post) {
        const std::size_t wall = add_entity(upright_square_mesh(1.1f, 1), finish(), 1, 1);
        scene.instances.push_back({wall, {}});
        if (has_post) {
            const std::size_t post =
                add_entity(box_mesh({-0.06f, -0.3f, 0}, {0.06f, 0.3f, 0.35f}), finish(), 1, 1);
            scene.instances.push_back({post, {{-1.25f, 0.2f, 0.32f}, 1}});
        }
        scene.environment = constant_environment(4, Rgb(0, 0, 0));
        scene.eye = camera().position;
        rays.build(scene);
    }
    static Camera camera() { return frontal_camera(3, side); }
    using ExampleScene::radiance;

    /// Returns the wall's radiance as baked, and in double.
    std::array<Rgb, 2> radiance(std::span<const PlacedLamp> lamps, const Vec3f& point) const {
        const Material material = finish();
        const Vec3f normal(0, 0, 1);
        const ShadingPoint receiver{
            point, point + normal * 1e-5f, point,
            surface_brdf<float>(material, normal, mirrored_view(scene.eye, point, normal))};
        Outgoing found;
        add_lamp_light(rays, lamps, {&receiver, 1}, {&found, 1});
        return {found.total(), Outgoing(radiance_from_lamps(lamps, rays, material, receiver)).total()};
    }

    ShadowRays rays;
};

Image picture(const WallAndPost& example, const Lamp& lamp) {
    const TestFolder folder;
    std::vector<ReferenceInstance> instances;
    for (std::size_t i = 0; i < example.scene.instances.size(); ++i) {
        const ShadedInstance& instance = example.scene.instances[i];
        instances.push_back({"instance_" + std::to_string(i), &example.mesh(instance.entity).original,
                             example.scene.entities[instance.entity].materials, instance.placement});
    }
    const Result<ReferenceFiles> files =
        write_reference_scene(folder.path(), "lamp", WallAndPost::camera(), instances,
                              example.scene.environment, 16, {}, {&lamp, 1});
    EXPECT_TRUE(files) << files.error().message();
    PovrayOptions options;
    options.width = options.height = side;
    options.declarations = {without_background};
    const Result<RenderedScene> rendered = rendered_scene(files->scene, options);
    EXPECT_TRUE(rendered) << rendered.error().message();
    return rendered ? rendered->image : Image{};
}

Vec3f wall_point(int x, int y) {
    return {float(2 * x + 1) / side - 1, 1 - float(2 * y + 1) / side, 0};
}

/// Tests whether the post is between the light and the visible part of the wall.
bool throws_into_the_picture(const Lamp& lamp) {
    return lamp.position.x < -1.2f;
}

TEST(Lamp, EachKindLightsAsPovrayDoes) {
    const WallAndPost wall(false);
    for (const auto& [name, lamp] : lamps()) {
        const Image image = picture(wall, lamp);
        ASSERT_EQ(image.pixels.size(), std::size_t(side * side)) << name;
        const std::vector<PlacedLamp> placed = placed_lamps({&lamp, 1});
        double brightest = 0;
        int wrong = 0;
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
                const Rgb& found = image.pixels[std::size_t(side * y + x)];
                for (const Rgb& expected : wall.radiance(placed, wall_point(x, y)))
                    for (int c = 0; c < 3; ++c)
                        if (!(std::abs(found[c] - expected[c]) <= 1e-3f * expected[c] + 2e-5f) && wrong++ < 3)
                            ADD_FAILURE() << name << ", pixel " << x << ", " << y << ": " << expected[c]
                                          << "; POV-Ray: " << found[c];
                brightest = std::max(brightest, double(found.x));
            }
        EXPECT_EQ(wrong, 0) << name;
        EXPECT_GT(brightest, 0.02) << name;
    }
}

TEST(Lamp, EachKindCastsTheShadowsOfPovray) {
    const WallAndPost wall(true), open(false);
    for (const auto& [name, lamp] : lamps()) {
        const Image image = picture(wall, lamp);
        ASSERT_EQ(image.pixels.size(), std::size_t(side * side)) << name;
        const std::vector<PlacedLamp> placed = placed_lamps({&lamp, 1});
        double error = 0, energy = 0;
        int shadowed = 0, left_out = 0;
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
                const Vec3f point = wall_point(x, y);
                const Rgb expected = wall.radiance(placed, point)[0];
                // At the edge of a shadow, both values are valid.
                bool is_edge = false;
                for (const Vec3f& beside :
                     {Vec3f(1, 0, 0), Vec3f(-1, 0, 0), Vec3f(0, 1, 0), Vec3f(0, -1, 0)}) {
                    const Rgb there = wall.radiance(placed, point + beside * 1e-3f)[0];
                    is_edge |= std::abs(there.x - expected.x) > 0.01f * (there.x + expected.x) + 1e-5f;
                }
                left_out += is_edge;
                if (is_edge) continue;
                const Rgb& found = image.pixels[std::size_t(side * y + x)];
                error += squared(found - expected);
                energy += squared(found);
                shadowed += expected.x < 0.98f * open.radiance(placed, point)[0].x;
            }
        EXPECT_LE(std::sqrt(error / energy), lamp.area ? 0.003 : 0.001) << name;
        EXPECT_LT(left_out, side * side / 10) << name;
        // Some lights are beyond the post or next to it.
        if (lamp.shadowless || !throws_into_the_picture(lamp))
            EXPECT_EQ(shadowed, 0) << name;
        else
            EXPECT_GT(shadowed, 20) << name;
    }
}

TEST(Lamp, PlacesOfAnAreaHaveWeightsThatAddUpToOne) {
    for (const std::uint32_t columns : {1u, 2u, 3u, 4u, 5u, 6u, 7u, 9u, 16u})
        for (const std::uint32_t rows : {1u, 4u, 5u}) {
            LampArea area;
            area.columns = columns;
            area.rows = rows;
            double sum = 0, across = 0;
            const std::vector<LampPlace> places = lamp_places(area);
            EXPECT_EQ(places.size(), std::size_t(columns) * rows);
            for (const LampPlace& place : places) {
                sum += place.weight;
                across += place.weight * place.across;
            }
            EXPECT_NEAR(sum, 1, 1e-12) << columns << " x " << rows;
            EXPECT_NEAR(across, 0, 1e-12) << columns << " x " << rows;
        }
}

/// The shape of a light (looks_like) does not shadow it, but shadows all others.
TEST(Lamp, ItsShapeCastsNoShadowOfItsLight) {
    WallAndPost example(true);
    Lamp bulb = lamp_at(LampKind::point, example.scene.instances[1].placement.translate + Vec3f(0, 0, 0.1f),
                        Vec3f(0.0f));
    const Vec3f point(0.2f, 0.1f, 0);
    const auto radiance = [&] { return example.radiance(placed_lamps({&bulb, 1}), point); };
    for (const Rgb& in_the_dark : radiance()) EXPECT_EQ(in_the_dark, Rgb(0.0f));
    bulb.looks_like = 1;
    const std::array<Rgb, 2> lit = radiance();
    EXPECT_GT(lit[0].x, 0.01f);
    EXPECT_NEAR(lit[0].x, lit[1].x, 1e-5f);
    EXPECT_EQ(lit[0], WallAndPost(false).radiance(placed_lamps({&bulb, 1}), point)[0]);
    bulb.looks_like = 0;
    for (const Rgb& in_the_dark : radiance()) EXPECT_EQ(in_the_dark, Rgb(0.0f));
}

/// Radiance of local lights and an environment is the sum of both, and agrees with the dense oracle.
TEST(Lamp, AddsToTheEnvironment) {
    WallAndPost example(true);
    const SceneColours dark = example.radiance();
    for (const std::vector<Rgb>& values : dark)
        for (const Rgb& value : values) EXPECT_EQ(value, Rgb(0.0f));
    example.scene.lamps = {lamp_at(LampKind::point, {-0.4f, 0.3f, 0.9f}, Vec3f(0.0f)),
                           with_area(lamp_at(LampKind::spot, {0.6f, -0.3f, 1.5f}, Vec3f(0.0f)), 3, 3)};
    const SceneColours lamps = example.radiance(), lamps_dense = example.dense();
    example.scene.environment = constant_environment(4, Rgb(0.5f));
    const SceneColours all = example.radiance();
    example.scene.lamps.clear();
    const SceneColours sky = example.radiance();
    double sum = 0;
    for (std::size_t i = 0; i < all.size(); ++i)
        for (std::size_t v = 0; v < all[i].size(); ++v)
            for (int c = 0; c < 3; ++c) {
                EXPECT_NEAR(all[i][v][c], sky[i][v][c] + lamps[i][v][c], 1e-5f);
                EXPECT_NEAR(lamps_dense[i][v][c], lamps[i][v][c], 1e-5f);
                sum += double(lamps[i][v][c]);
            }
    EXPECT_GT(sum, 1);
}

}  // namespace
}  // namespace haarfield
