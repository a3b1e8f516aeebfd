#include "tools/view/design.h"

#include <gtest/gtest.h>

namespace haarfield {
namespace {

Design room() {
    Design design;
    for (const char* name : {"floor", "chair"}) design.scene.entities.emplace_back().name = name;
    design.scene.materials["oak"] = {};
    design.scene.instances = {{"floor", 0, {}, {}}, {"chair_1", 1, {}, {}}, {"chair_2", 1, {}, {}}};
    design.scene.keyframes = {{1, 1, Vec3f(1, 0, 0), {}, {}}, {1, 2, Vec3f(0, 0, 1), {}, {}}};
    design.ids = {1, 2, 3};
    design.entities = {0, 1, 1};
    return design;
}

TEST(ViewDesign, EditsAreUndoneAndRedone) {
    History history(room());
    EXPECT_FALSE(history.undo());
    ASSERT_TRUE(bool(history.make(PlaceObject{2, {{1, 0, 0}, 1, {}}}, 0)));
    ASSERT_TRUE(bool(history.make(PlaceObject{2, {{2, 0, 0}, 1, {}}}, 0)));
    EXPECT_TRUE(history.undo());
    EXPECT_EQ(history.now().scene.instances[1].placement.translate.x, 1);
    EXPECT_TRUE(history.undo());
    EXPECT_EQ(history.now().scene.instances[1].placement.translate.x, 0);
    EXPECT_FALSE(history.undo());
    EXPECT_TRUE(history.redo());
    EXPECT_TRUE(history.redo());
    EXPECT_FALSE(history.redo());
    EXPECT_EQ(history.now().scene.instances[1].placement.translate.x, 2);
    // A new step clears the redo history.
    EXPECT_TRUE(history.undo());
    ASSERT_TRUE(bool(history.make(SetExposure{1.0f}, 0)));
    EXPECT_FALSE(history.can_redo());
}

TEST(ViewDesign, AGestureIsOneStep) {
    History history(room());
    for (int i = 1; i <= 5; ++i)
        ASSERT_TRUE(bool(history.make(PlaceObject{3, {{float(i), 0, 0}, 1, {}}}, 7)));
    ASSERT_TRUE(bool(history.make(SetExposure{1.0f}, 8)));
    EXPECT_TRUE(history.undo());
    EXPECT_EQ(history.now().scene.instances[2].placement.translate.x, 5);
    EXPECT_TRUE(history.undo());
    EXPECT_EQ(history.now().scene.instances[2].placement.translate.x, 0);
    EXPECT_FALSE(history.can_undo());
}

TEST(ViewDesign, ARestoredSceneHasNewObjectsAndIsTakenBack) {
    History history(room());
    Scene left = room().scene;
    left.instances.push_back({"chair_3", 1, {{0, 0, 2}, 1, {}}, {}});
    left.instances.erase(left.instances.begin() + 1);
    EXPECT_TRUE(is_changed(left, history.now().scene));
    ASSERT_TRUE(bool(history.make(RestoreScene{left}, 0)));
    EXPECT_EQ(history.now().ids, (std::vector<std::uint32_t>{4, 5, 6}));
    EXPECT_EQ(history.now().entities, (std::vector<std::size_t>{0, 1, 1}));
    EXPECT_FALSE(is_changed(history.now().scene, left));
    EXPECT_TRUE(history.undo());
    EXPECT_EQ(history.now().ids, (std::vector<std::uint32_t>{1, 2, 3}));
}

TEST(ViewDesign, ASceneWithOtherMeshesIsNotRestored) {
    History history(room());
    Scene left = room().scene;
    left.entities[1].fine_vertices = 10;
    EXPECT_FALSE(history.make(RestoreScene{left}, 0));
    EXPECT_FALSE(history.can_undo());
}

TEST(ViewDesign, ACameraIsNoUnsavedChange) {
    Scene other = room().scene;
    other.camera.position = {7, 7, 7};
    EXPECT_FALSE(is_changed(other, room().scene));
}

TEST(ViewDesign, EqualStampsAreEqualContents) {
    History history(room());
    const std::uint64_t at_first = history.now().material_stamp;
    SceneMaterial red;
    red.diffuse = {1, 0, 0};
    ASSERT_TRUE(bool(history.make(SetMaterial{"oak", red}, 0)));
    const std::uint64_t with_red = history.now().material_stamp;
    EXPECT_NE(with_red, at_first);
    EXPECT_TRUE(history.undo());
    EXPECT_EQ(history.now().material_stamp, at_first);
    ASSERT_TRUE(bool(history.make(SetMaterial{"oak", {}}, 0)));
    EXPECT_NE(history.now().material_stamp, with_red);
}

TEST(ViewDesign, CopiesHaveNamesAndIdsOfTheirOwn) {
    History history(room());
    ASSERT_TRUE(bool(history.make(CloneObject{3}, 0)));
    EXPECT_EQ(history.now().scene.instances.back().name, "chair_3");
    EXPECT_EQ(history.now().ids.back(), 4u);
    ASSERT_TRUE(bool(history.make(DeleteObject{4}, 0)));
    ASSERT_TRUE(bool(history.make(CloneObject{2}, 0)));
    EXPECT_EQ(history.now().ids.back(), 5u);  // 4 may be restored
    EXPECT_TRUE(history.undo());
    EXPECT_TRUE(history.undo());
    EXPECT_EQ(history.now().ids.back(), 4u);
}

TEST(ViewDesign, DeletedObjectsLoseTheirKeyframes) {
    History history(room());
    ASSERT_TRUE(bool(history.make(DeleteObject{2}, 0)));
    const Scene& scene = history.now().scene;
    ASSERT_EQ(scene.instances.size(), 2u);
    ASSERT_EQ(scene.keyframes.size(), 1u);
    EXPECT_EQ(scene.instances[scene.keyframes[0].instance].name, "chair_2");
}

TEST(ViewDesign, LampsKeepTheirShapesAfterDeletions) {
    Design design = room();
    design.scene.lamps.resize(2);
    design.scene.lamps[0].looks_like = 1;
    design.scene.lamps[1].looks_like = 2;
    History history(design);
    ASSERT_TRUE(bool(history.make(DeleteObject{2}, 0)));
    const std::vector<SceneLamp>& lamps = history.now().scene.lamps;
    EXPECT_EQ(lamps[0].looks_like, std::nullopt);
    EXPECT_EQ(lamps[1].looks_like, 1u);
    EXPECT_TRUE(history.undo());
    EXPECT_EQ(history.now().scene.lamps[0].looks_like, 1u);
}

TEST(ViewDesign, EditsThatFailChangeNothing) {
    History history(room());
    for (const Edit& edit : {Edit(PlaceObject{9, {}}), Edit(CloneObject{0}), Edit(DeleteObject{9}),
                             Edit(MixLights{0.5f}), Edit(SetMaterial{"gold", {}})})
        EXPECT_FALSE(bool(history.make(edit, 0)));
    EXPECT_FALSE(history.can_undo());
    for (const std::uint32_t object : {1u, 2u}) ASSERT_TRUE(bool(history.make(DeleteObject{object}, 0)));
    EXPECT_FALSE(bool(history.make(DeleteObject{3}, 0)));  // the last one
    EXPECT_EQ(history.now().ids.size(), 1u);
}

TEST(ViewDesign, MovingTheCameraIsAnEdit) {
    History history(room());
    const Camera first = history.now().scene.camera;
    ASSERT_TRUE(bool(history.make(SetExposure{1.0f}, 0)));
    for (int i = 1; i <= 5; ++i) ASSERT_TRUE(bool(history.make(MoveEye{{float(i), 2, 1}, {0, 1, 0}}, 7)));
    EXPECT_EQ(history.now().scene.camera.vertical_fov, first.vertical_fov);
    EXPECT_TRUE(history.undo());
    EXPECT_EQ(history.now().scene.camera.position, first.position);
    EXPECT_EQ(history.now().scene.camera.target, first.target);
    EXPECT_EQ(history.now().scene.environment.exposure, 1.0f);
    EXPECT_TRUE(history.redo());
    EXPECT_EQ(history.now().scene.camera.position, Vec3f(5, 2, 1));
    EXPECT_EQ(history.now().scene.camera.target, Vec3f(0, 1, 0));
}

TEST(ViewDesign, GesturesOfTwoPagesAreTwoSteps) {
    History history(room());
    ASSERT_TRUE(bool(history.make(SetExposure{1.0f}, 1)));
    history.end_gesture();
    ASSERT_TRUE(bool(history.make(SetExposure{2.0f}, 1)));
    EXPECT_TRUE(history.undo());
    EXPECT_EQ(history.now().scene.environment.exposure, 1.0f);
}

}  // namespace
}  // namespace haarfield
