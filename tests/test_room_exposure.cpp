#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "scenes/scene_entities.h"
#include "scenes/scene_environment.h"
#include "tests/fixtures/test_folder.h"

namespace haarfield {
namespace {

constexpr float half_window = 0.5f;  // [m]

/// A room of 4 x 3 x 4 m with a square window in the middle of the wall at z = -2. The camera is next to the
/// window and faces the middle of the opposite wall.
class RoomExposure : public testing::Test {
protected:
    RoomExposure() {
        scene.environment.sky = AnalyticSky();  // not used: tests pass the environment
        scene.environment.exposure.reset();
        scene.camera.position = {0, 1.5f, -1.5f};
        scene.camera.target = {0, 1.5f, 2};
        scene.camera.vertical_fov = 0.1f;
        scene.materials["clay"];
        Entity room;
        room.name = "room";
        room.mesh = folder / "room.obj";
        room.material = "clay";
        room.fine_vertices = 0;
        room.coarse_triangles = 0;
        write_room(room.mesh, half_window);
        scene.entities.push_back(room);
        scene.instances.push_back({"room", 0, {}});
    }

    static void write_room(const std::filesystem::path& file, float half) {
        std::string text;
        for (const float z : {-2.0f, 2.0f})
            for (const auto& [x, y] : {std::pair(-2.0f, 0.0f), std::pair(2.0f, 0.0f), std::pair(2.0f, 3.0f),
                                       std::pair(-2.0f, 3.0f)})
                text += fmt::format("v {} {} {}\n", x, y, z);
        for (const auto& [x, y] :
             {std::pair(-half, -half), std::pair(half, -half), std::pair(half, half), std::pair(-half, half)})
            text += fmt::format("v {} {} -2\n", x, 1.5f + y);
        text += "f 5 8 7 6\nf 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 4 8 5 1\n";
        text += "f 1 2 10 9\nf 2 3 11 10\nf 3 4 12 11\nf 4 1 9 12\n";
        write_text(file, text);
    }

    /// Adds a square that emits light on one side.
    void add_panel(const std::array<Vec3d, 4>& corners, double radiance) {
        const std::string name = fmt::format("panel_{}", scene.entities.size());
        std::string text;
        for (const Vec3d& corner : corners) text += fmt::format("v {} {} {}\n", corner.x, corner.y, corner.z);
        write_text(folder / (name + ".obj"), text + "f 1 2 3 4\n");
        scene.materials[name].emission = Rgb(float(radiance));
        Entity panel;
        panel.name = panel.material = name;
        panel.mesh = folder / (name + ".obj");
        panel.fine_vertices = 0;
        panel.coarse_triangles = 0;
        scene.instances.push_back({name, scene.entities.size(), {}});
        scene.entities.push_back(panel);
    }

    SceneEntities entities() const {
        SceneEntityOptions meshes_only;
        meshes_only.fields = FieldExtent::none;
        Result<SceneEntities> prepared = prepare_scene_entities(scene, meshes_only);
        EXPECT_TRUE(prepared) << prepared.error().message();
        return std::move(*prepared);
    }
    float stops() const { return entity_stops(scene, entities(), white_light); }

    TestFolder folder;
    Scene scene;
    const Environment white_light{LatLongImage{64, 32, std::vector<Rgb>(64 * 32, Rgb(1.0f))}};
};

/// Returns the irradiance by the window in the middle of the opposite wall, divided by pi.
double share_of_window() {
    constexpr int cells = 200;
    constexpr double distance = 4, side = 2 * double(half_window) / cells;
    double sum = 0;
    for (int i = 0; i < cells; ++i)
        for (int j = 0; j < cells; ++j) {
            const double x = (i + 0.5) * side - double(half_window),
                         y = (j + 0.5) * side - double(half_window),
                         squared = x * x + y * y + distance * distance;
            sum += distance * distance / (squared * squared) * side * side;
        }
    return sum / pi;
}

TEST_F(RoomExposure, BringsWhitePaintInTheLightOfAWindowToOne) {
    // Light that the walls reflect, spread evenly over them: areas in m^2.
    const double albedo = 0.5;
    scene.materials["clay"].diffuse = Rgb(float(albedo));
    constexpr double window = 1, walls = 2 * 16 + 4 * 12 - window, once = window / walls;
    const double direct = share_of_window(), reflected = once * (albedo / (1 - albedo)),
                 white = 0.8 * (direct + reflected);
    EXPECT_NEAR(stops(), -std::log2(white), 0.4);
}

TEST_F(RoomExposure, DependsOnTheColoursOfSurfacesAndLight) {
    scene.materials["clay"].diffuse = Rgb(0.0f);
    const float black = stops();
    EXPECT_NEAR(black, -std::log2(0.8 * share_of_window()), 0.25);
    scene.materials["clay"].diffuse = Rgb(0.8f, 0.4f, 0.4f);
    const float red = stops();
    EXPECT_LT(red, black - 0.5f);
    scene.materials["clay"].diffuse = Rgb(0.8f);
    EXPECT_NEAR(stops(), red, 0.02) << "the same in the largest channel";
    const Environment blue{LatLongImage{64, 32, std::vector<Rgb>(64 * 32, Rgb(0.1f, 0.1f, 2.0f))}};
    EXPECT_NEAR(entity_stops(scene, entities(), blue), stops() - 1, 0.02);
}

TEST_F(RoomExposure, IsZeroOutdoors) {
    scene.camera.position = {0, 1.5f, -6};
    EXPECT_EQ(stops(), 0);
}

TEST_F(RoomExposure, IsZeroWithAGivenExposureAndInARoomWithoutOpenings) {
    scene.environment.exposure = 1.0f;
    EXPECT_EQ(stops(), 0);
    scene.environment.exposure.reset();
    write_room(scene.entities[0].mesh, 0);
    EXPECT_EQ(stops(), 0);
}

TEST_F(RoomExposure, DoesNotDependOnTheMeshesThatShow) {
    const float found = stops();
    EXPECT_GT(found, 3);
    const Result<SceneEntities> originals = original_entities(scene);
    ASSERT_TRUE(originals);
    EXPECT_EQ(entity_stops(scene, *originals, white_light), found);
    scene.entities[0].fine_vertices = 3000;
    EXPECT_EQ(stops(), found);
}

TEST_F(RoomExposure, CountsTheLightOfLamps) {
    const float without = stops();
    SceneLamp lamp;
    lamp.position = {0, 1.5f, 0};
    lamp.colour = Rgb(0.5f / 0.8f);
    scene.lamps.push_back(lamp);
    EXPECT_NEAR(stops(), without - 1, 0.1);
    scene.lamps[0].colour = Rgb(10.0f);
    EXPECT_NEAR(stops(), without - 4, 0.1) << "a sixteenth";
}

TEST_F(RoomExposure, CountsTheLightOfEmitters) {
    const auto irradiance = [](const std::array<Vec3d, 4>& corners, const Vec3d& point, const Vec3d& normal) {
        return triangle_irradiance({corners[0], corners[1], corners[2]}, point, normal) +
               triangle_irradiance({corners[0], corners[2], corners[3]}, point, normal);
    };
    scene.camera.vertical_fov = 0.005f;  // so small that all visible points have the same light
    const float without = stops();
    // The panel is below the ceiling and faces down. It lights the visible middle of the wall.
    const std::array<Vec3d, 4> panel{Vec3d(-0.5, 2.9, 0.9), Vec3d(0.5, 2.9, 0.9), Vec3d(0.5, 2.9, 1.9),
                                     Vec3d(-0.5, 2.9, 1.9)};
    const double on_wall = irradiance(panel, {0, 1.5, 2}, {0, 0, -1});
    add_panel(panel, 0.5 * pi / (0.8 * on_wall));
    EXPECT_NEAR(stops(), without - 1, 0.1);

    scene.camera.position = {0, 1.5f, -6};
    scene.camera.target = {0, 1.5f, -8};
    EXPECT_NEAR(stops(), 0, 0.02) << "outdoors, where nothing emits light";
    const std::array<Vec3d, 4> sign{Vec3d(-0.5, 1, -10), Vec3d(0.5, 1, -10), Vec3d(0.5, 2, -10),
                                    Vec3d(-0.5, 2, -10)};
    add_panel(sign, 0.5 * pi / (0.8 * irradiance(sign, {0, 1.5, -8}, {0, 0, -1})));
    EXPECT_NEAR(stops(), -1, 0.05) << "outdoors, before a sign";
}

}  // namespace
}  // namespace haarfield
