#include "tools/view/scene_file.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "scenes/scene_reader.h"
#include "tests/fixtures/test_folder.h"

namespace haarfield {
namespace {

constexpr const char* plain_scene =
    "# On top.\n[camera]\nposition = [1, 1, 2]\ntarget = [0, 0, 0]\n"
    "[environment]\nsky = { turbidity = 3, sun_elevation = 40 }\n"
    "[entities.chair]\nmesh = \"chair.obj\"\n[[instances]]\nentity = \"chair\"\n";

/// A scene that was opened from a file in a temporary folder.
struct Opened {
    explicit Opened(const std::string& text) {
        write_text(folder / "chair.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        write_text(folder / "room.toml", text);
        scene = *read_scene(folder / "room.toml");
        scene.camera.position = {3, 2, 1};
    }

    /// Saves the scene. Returns the name of the written file; empty after an error or if its content differs.
    std::string saved(SceneFile& file, std::string_view name = {}) const {
        const Result<SavedScene> result = file.save(scene, name);
        if (!result) return "";
        const Result<Scene> back = read_scene(result->file);
        const bool is_same = back && back->camera.position == scene.camera.position;
        return is_same ? result->file.filename().string() : "";
    }

    TestFolder folder;
    Scene scene;
};

TEST(ViewSceneFile, KeepsItsNameAndTheCommentsOnTop) {
    const Opened opened(plain_scene);
    SceneFile file(opened.folder / "room.toml");
    for (int times = 0; times < 2; ++times) {
        EXPECT_EQ(opened.saved(file), "room.toml");
        EXPECT_TRUE(text_of(opened.folder / "room.toml").starts_with("# On top.\n\n"));
    }
    EXPECT_EQ(opened.saved(file, "other"), "other.toml");
    EXPECT_TRUE(text_of(opened.folder / "other.toml").starts_with("# On top.\n\n"));
}

TEST(ViewSceneFile, IsAutosavedNextToTheSceneUntilItIsSaved) {
    const Opened opened(plain_scene);
    const SceneFile file(opened.folder / "room.toml");
    EXPECT_FALSE(file.left_scene());
    ASSERT_TRUE(bool(file.autosave(&opened.scene)));
    EXPECT_TRUE(std::filesystem::exists(opened.folder / "room.autosave.toml"));
    const std::optional<Result<Scene>> left = SceneFile(opened.folder / "room.toml").left_scene();
    ASSERT_TRUE(left && *left);
    EXPECT_EQ((*left)->camera.position, opened.scene.camera.position);
    ASSERT_TRUE(bool(file.autosave(nullptr)));
    EXPECT_FALSE(file.left_scene());
    EXPECT_TRUE(bool(file.autosave(nullptr)));
}

TEST(ViewSceneFile, WithCommentsFurtherDownIsNotChanged) {
    const std::string text = fmt::format("{}# Stands free.\n", plain_scene);
    const Opened opened(text);
    write_text(opened.folder / "room.view.toml", "another's");
    SceneFile file(opened.folder / "room.toml");
    for (const std::string_view name : {"", "room", "room.toml", ""})  // overwrites the session's file
        EXPECT_EQ(opened.saved(file, name), "room.view_2.toml");
    EXPECT_EQ(text_of(opened.folder / "room.toml"), text);
    EXPECT_EQ(text_of(opened.folder / "room.view.toml"), "another's");
    EXPECT_EQ(file.save(opened.scene)->instead_of, opened.folder / "room.toml");
    EXPECT_TRUE(file.save(opened.scene, "new")->instead_of.empty());
    // A later session does not overwrite the file of an earlier one.
    SceneFile later(opened.folder / "room.toml");
    EXPECT_EQ(opened.saved(later), "room.view_3.toml");
}

TEST(ViewSceneFile, CommentsThatComeWhileItIsOpenAreNotLost) {
    const Opened opened(plain_scene);
    SceneFile file(opened.folder / "room.toml");
    EXPECT_EQ(opened.saved(file), "room.toml");
    std::vector<std::string> commented;
    for (const char* next : {"room.view.toml", "room.view_2.toml"}) {
        const std::filesystem::path last =
            opened.folder / (commented.empty() ? "room.toml" : "room.view.toml");
        commented.push_back(text_of(last) + "# Written meanwhile.\n");
        write_text(last, commented.back());
        EXPECT_EQ(opened.saved(file), next);
    }
    EXPECT_EQ(text_of(opened.folder / "room.toml"), commented[0]);
    EXPECT_EQ(text_of(opened.folder / "room.view.toml"), commented[1]);
}

TEST(ViewSceneFile, OverwritesNoOtherFile) {
    const Opened opened(plain_scene);
    write_text(opened.folder / "other.toml", plain_scene);
    SceneFile file(opened.folder / "room.toml");
    const Result<SavedScene> over = file.save(opened.scene, "other");
    ASSERT_FALSE(bool(over));
    EXPECT_NE(over.error().message().find("other.toml: exists already"), std::string::npos);
    EXPECT_EQ(text_of(opened.folder / "other.toml"), plain_scene);
    for (const char* name : {"../outside", ".hidden", "-o"}) {
        const std::vector<std::string> files = opened.folder.files();
        EXPECT_FALSE(bool(file.save(opened.scene, name))) << name;
        EXPECT_EQ(opened.folder.files(), files) << name;
    }
    // A session may overwrite a file that it has created.
    EXPECT_EQ(opened.saved(file, "mine"), "mine.toml");
    EXPECT_EQ(opened.saved(file, "mine"), "mine.toml");
}

}  // namespace
}  // namespace haarfield
