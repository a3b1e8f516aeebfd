#include "scenes/scene_camera.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/fixtures/test_folder.h"

namespace haarfield {
namespace {

/// Boxes of any size, each an entity and an instance, prepared like those of commands.
class SceneCamera : public testing::Test {
protected:
    SceneCamera() {
        scene.finds_camera = true;
        scene.materials["clay"];
    }

    /// Adds an axis-aligned box, optionally with a placement.
    void add_box(const Vec3f& lower, const Vec3f& upper, const Placement& placement = {}) {
        Entity entity;
        entity.name = fmt::format("box_{}", scene.entities.size());
        entity.mesh = folder / (entity.name + ".obj");
        entity.material = "clay";
        entity.fine_vertices = 0;
        entity.coarse_triangles = 0;
        std::string text;
        for (int i = 0; i < 8; ++i) {
            corners.push_back(placement.point_to_world(
                Vec3f((i & 1 ? upper : lower).x, (i & 2 ? upper : lower).y, (i & 4 ? upper : lower).z)));
            text += fmt::format("v {} {} {}\n", (i & 1 ? upper : lower).x, (i & 2 ? upper : lower).y,
                                (i & 4 ? upper : lower).z);
        }
        write_text(entity.mesh, text + "f 1 5 7 3\nf 2 4 8 6\nf 1 2 6 5\nf 3 7 8 4\nf 1 3 4 2\nf 5 6 8 7\n");
        scene.instances.push_back({entity.name, scene.entities.size(), placement});
        scene.entities.push_back(std::move(entity));
    }

    SceneEntities entities() const {
        SceneEntityOptions meshes_only;
        meshes_only.fields = FieldExtent::none;
        Result<SceneEntities> prepared = prepare_scene_entities(scene, meshes_only);
        EXPECT_TRUE(prepared) << prepared.error().message();
        return std::move(*prepared);
    }
    Camera found() const { return scene_camera(scene, entities()); }
    std::vector<std::string> troubles() const { return camera_troubles(scene, entities()); }

    TestFolder folder;
    Scene scene;
    std::vector<Vec3f> corners;  ///< Corners of all boxes, in the world.
};

/// Returns the position of a point in the picture of a pinhole camera, in units of half the width and height.
std::array<double, 2> place_in_picture(const Camera& camera, const Vec3f& point) {
    const Vec3d forward = (Vec3d(camera.target) - Vec3d(camera.position)).normalized(),
                right = forward.cross({0, 1, 0}).normalized(), up = right.cross(forward),
                ray = Vec3d(point) - Vec3d(camera.position);
    const double half_height = std::tan(double(camera.vertical_fov) / 2),
                 half_width = half_height * camera.width / camera.height, depth = ray.dot(forward);
    EXPECT_GT(depth, 0);
    return {ray.dot(right) / depth / half_width, ray.dot(up) / depth / half_height};
}

TEST_F(SceneCamera, CountedObjectsFillNineTenthsOfThePicture) {
    add_box({-0.2f, 0, -0.3f}, {0.2f, 1.1f, 0.4f});
    add_box({-0.5f, -0.5f, -0.5f}, {0.5f, 0.5f, 0.5f}, {{2, 0.7f, -1}, 0.6f, rotation_about({1, 2, 3}, 1)});
    add_box({100, 20, -50}, {101, 20.5f, -49}, {{-98, -19, 50}, 1});
    for (const auto& [width, height] : {std::array{640, 480}, {300, 900}, {1600, 200}})
        for (const float fov : {0.05f, 0.6f, 1.5f, 2.0f}) {
            scene.camera.width = width;
            scene.camera.height = height;
            scene.camera.vertical_fov = fov;
            const Camera camera = found();
            EXPECT_EQ(camera.width, width);
            EXPECT_EQ(camera.vertical_fov, fov);
            std::array<double, 2> lowest{1, 1}, highest{-1, -1};
            for (const Vec3f& corner : corners)
                for (std::size_t axis = 0; axis < 2; ++axis) {
                    const double at = place_in_picture(camera, corner)[axis];
                    lowest[axis] = std::min(lowest[axis], at);
                    highest[axis] = std::max(highest[axis], at);
                }
            const std::string which = fmt::format("{} x {}, {} rad", width, height, fov);
            for (std::size_t axis = 0; axis < 2; ++axis) {
                EXPECT_GE(lowest[axis], -0.9 - 1e-4) << which;
                EXPECT_LE(highest[axis], 0.9 + 1e-4) << which;
            }
            const auto fills = [&](std::size_t axis) {
                return std::abs(lowest[axis] + 0.9) < 1e-4 && std::abs(highest[axis] - 0.9) < 1e-4;
            };
            EXPECT_TRUE(fills(0) || fills(1)) << which;
        }
}

TEST_F(SceneCamera, LooksFromTheFrontRightAndAbove) {
    add_box({3, 0, 4}, {4, 1, 5});
    const Camera camera = found();
    const Vec3d to_eye = (Vec3d(camera.position) - Vec3d(camera.target)).normalized();
    EXPECT_NEAR(std::atan2(to_eye.x, to_eye.z), 35 * pi / 180, 1e-5);
    EXPECT_NEAR(std::asin(to_eye.y), 25 * pi / 180, 1e-5);
    // The box is 1.59 m deep along the view, with the target at its centre.
    EXPECT_NEAR((Vec3d(camera.target) - Vec3d(3.5, 0.5, 4.5)).dot(to_eye), 0, 1e-5);
}

TEST_F(SceneCamera, LeavesGroundsOutButNoSmallerSheets) {
    add_box({-0.5f, 0, -0.5f}, {0.5f, 1, 0.5f});
    const Camera alone = found();
    add_box({-20, -0.1f, -20}, {20, 0, 20});
    EXPECT_EQ(found().position, alone.position);
    const auto distance = [](const Camera& camera) { return (camera.position - camera.target).length(); };
    add_box({-0.4f, -0.01f, 1}, {0.4f, 0, 3});  // a rug: deeper than the box, but not as wide
    const Camera with_runner = found();
    EXPECT_GT(distance(with_runner), distance(alone));
    add_box({-3, -0.01f, 1}, {3, 0, 1.4f});  // wider, but not as deep
    EXPECT_GT(distance(found()), distance(with_runner));
}

TEST_F(SceneCamera, ShowsGroundsWhereThereIsNothingElse) {
    add_box({-5, -0.1f, -5}, {5, 0, 5});
    add_box({20, -0.1f, -5}, {30, 0, 5});
    const Camera camera = found();
    for (const Vec3f& corner : corners) EXPECT_LE(std::abs(place_in_picture(camera, corner)[0]), 0.9 + 1e-4);
}

TEST_F(SceneCamera, IsLeftWhereTheAuthorPutIt) {
    add_box({0, 0, 0}, {1, 1, 1});
    scene.finds_camera = false;
    scene.camera.position = {7, 8, 9};
    EXPECT_EQ(found().position, Vec3f(7, 8, 9));
    EXPECT_EQ(found().target, scene.camera.target);
}

TEST_F(SceneCamera, WarnsOfInstancesThatContainIt) {
    add_box({-1, -1, -1}, {1, 1, 1}, {{3, 0, 0}, 2, rotation_about({0, 1, 0}, 0.5)});
    add_box({-1, -1, -1}, {1, 1, 1});
    scene.camera.target = {0, 0, 0};
    scene.camera.position = {-0.9f, 0.2f, 0.1f};
    EXPECT_EQ(
        troubles(),
        (std::vector<std::string>{
            "the camera is inside box_1; if that is a room, add faces = \"inwards\" to [entities.box_1]"}));
    scene.camera.position = {4.5f, 1.5f, 0};
    EXPECT_EQ(
        troubles(),
        (std::vector<std::string>{
            "the camera is inside box_0; if that is a room, add faces = \"inwards\" to [entities.box_0]"}));
    scene.camera.position = {0, 0, 6};
    EXPECT_EQ(troubles(), std::vector<std::string>{});
}

TEST_F(SceneCamera, WarnsOfInstancesThatAreSmallerThanAPixel) {
    add_box({-1, -1, -1}, {1, 1, 1});
    scene.camera.position = {0, 0, 6};
    scene.camera.target = {0, 0, 0};
    add_box({-1, -1, -1}, {1, 1, 1}, {{1.5f, 0, 0}, 0.01f});
    EXPECT_EQ(troubles(), std::vector<std::string>{}) << "a few pixels large";
    add_box({-1, -1, -1}, {1, 1, 1}, {{1.5f, 0, 0}, 0.0001f});  // 1 % in size, applied twice
    add_box({-1, -1, -1}, {1, 1, 1}, {{0, 0, 20}, 0.0001f});    // behind the camera
    EXPECT_EQ(troubles(), (std::vector<std::string>{
                              "smaller than a pixel in the picture: \"box_2\"; is a scale applied twice?"}));
}

TEST_F(SceneCamera, WarnsIfNothingIsVisible) {
    add_box({-50, -1, -50}, {50, 0, 50});
    const std::vector<std::string> nothing{"no object is in the picture"};
    scene.camera.position = {0, 2, 0};
    scene.camera.vertical_fov = 0.5f;
    scene.camera.target = {0, 0, 1};  // not on a vertex
    EXPECT_EQ(troubles(), std::vector<std::string>{});
    scene.camera.target = {0, 3, 1};
    EXPECT_EQ(troubles(), nothing);
    scene.camera.target = {1, 2, 0};  // beyond the floor, towards the horizon: 0.25 rad below
    EXPECT_EQ(troubles(), std::vector<std::string>{});
    scene.camera.vertical_fov = 0.02f;  // 0.04 rad below
    EXPECT_EQ(troubles(), nothing);
    scene.camera.position = {0, 2, 60};  // behind the camera
    scene.camera.target = {0, 2, 61};
    scene.camera.vertical_fov = 2.5f;
    EXPECT_EQ(troubles(), nothing);
}

}  // namespace
}  // namespace haarfield
