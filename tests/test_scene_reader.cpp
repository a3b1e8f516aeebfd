#include "scenes/scene_reader.h"
#include "scenes/scene_writer.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <random>
#include <regex>
#include <sstream>

namespace haarfield {
namespace {

constexpr const char* valid_scene = R"([camera]
position = [3.2, 1.8, 4]
target = [0.0, 0.5, 0.0]
vertical_fov = 35.0
resolution = [640, 480]

[environment]
sky = { turbidity = 3, sun_elevation = 40, sun_azimuth = 90, sun_angular_radius = 0.5, ground = [0.2, 0.2, 0.1] }
rotation = 90
exposure = -1.5

[materials.lacquer]
diffuse = [0.25, 0.08, 0.04]
specular = [0.3, 0.3, 0.3]
shininess = 60
convention = "povray"
[materials.cloth]
diffuse = [1, 0, 0.5]

[entities.table]
mesh = "box.obj"
material = "lacquer"
materials = { seat = "cloth" }
fine_vertices = 25000
coarse_triangles = 0
planar_samples = 200
spherical_samples = 100

[entities.chair]
mesh = "box.obj"
material = "cloth"

[entities.unused]
mesh = "box.obj"
material = "cloth"

[[instances]]
entity = "table"
translate = [0.0, -1, 0.5]
scale = 2
rotate = [0, 90, 0]
[[instances]]
entity = "chair"
[[instances]]
entity = "chair"
)";

class SceneReader : public testing::Test {
protected:
    void SetUp() override {
        const auto* test = testing::UnitTest::GetInstance()->current_test_info();
        folder_ = std::filesystem::path(testing::TempDir()) / fmt::format("scene_reader_{}", test->name());
        std::filesystem::create_directories(folder_);
        std::ofstream(folder_ / "box.obj") << "v 0 0 0\n";
        std::ofstream(folder_ / "light.exr") << "light";
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    Result<Scene> read(const std::string& text) {
        std::filesystem::remove(folder_ / "room.toml");  // overwriting waits for the disk on some systems
        std::ofstream(folder_ / "room.toml", std::ios::binary) << text;
        return read_scene(folder_ / "room.toml");
    }

    /// Returns the error of the valid scene after one replacement, without the path of the folder.
    std::string message_with(const std::string& from, const std::string& to) {
        std::string text = valid_scene;
        const std::size_t at = text.find(from);
        EXPECT_NE(at, std::string::npos) << from;
        text.replace(at, from.size(), to);
        const Result<Scene> scene = read(text);
        if (scene) return "accepted";
        const std::string message = scene.error().message();
        return message.substr(std::min(message.size(), folder_.string().size() + 1));
    }

    std::filesystem::path folder_;
};

TEST_F(SceneReader, ReadsEveryKeyInItsUnit) {
    const Result<Scene> read_back = read(valid_scene);
    ASSERT_TRUE(read_back) << read_back.error().message();
    const Scene& scene = *read_back;
    EXPECT_EQ(scene.name, "room");
    EXPECT_EQ(scene.camera.position, Vec3f(3.2f, 1.8f, 4.0f));
    EXPECT_EQ(scene.camera.target, Vec3f(0.0f, 0.5f, 0.0f));
    EXPECT_NEAR(scene.camera.vertical_fov, 35 * pi / 180, 1e-6);
    EXPECT_EQ(scene.camera.width, 640);
    EXPECT_EQ(scene.camera.height, 480);

    ASSERT_TRUE(scene.environment.sky);
    EXPECT_TRUE(scene.environment.image.empty());
    EXPECT_EQ(scene.environment.sky->turbidity, 3.0f);
    EXPECT_NEAR(scene.environment.sky->sun_elevation, 40 * pi / 180, 1e-6);
    EXPECT_NEAR(scene.environment.sky->sun_azimuth, pi / 2, 1e-6);
    EXPECT_NEAR(scene.environment.sky->sun_angular_radius, 0.5 * pi / 180, 1e-8);
    EXPECT_EQ(scene.environment.sky->ground, Rgb(0.2f, 0.2f, 0.1f));
    EXPECT_NEAR(scene.environment.rotation, pi / 2, 1e-6);
    EXPECT_EQ(scene.environment.exposure, -1.5f);

    ASSERT_EQ(scene.materials.size(), 2u);
    const Material& lacquer = scene.materials.at("lacquer");
    EXPECT_EQ(lacquer.diffuse, Rgb(0.25f, 0.08f, 0.04f));
    EXPECT_EQ(lacquer.specular, Rgb(0.3f, 0.3f, 0.3f));
    EXPECT_EQ(lacquer.shininess, 60.0f);
    EXPECT_EQ(lacquer.convention, LobeConvention::povray);
    EXPECT_EQ(scene.materials.at("cloth").convention, LobeConvention::physical);

    ASSERT_EQ(scene.entities.size(), 3u);
    EXPECT_EQ(scene.entities[0].name, "table");  // the order of the file, not of the alphabet
    EXPECT_EQ(scene.entities[1].name, "chair");
    EXPECT_EQ(scene.entities[2].name, "unused");
    const Entity& table = scene.entities[0];
    EXPECT_EQ(table.mesh, folder_ / "box.obj");
    EXPECT_EQ(table.material, "lacquer");
    EXPECT_EQ(table.materials, (std::map<std::string, std::string>{{"seat", "cloth"}}));
    EXPECT_EQ(table.fine_vertices, 25000u);
    EXPECT_EQ(table.coarse_triangles, 0u);
    EXPECT_EQ(table.planar_samples, 200u);
    EXPECT_EQ(table.spherical_samples, 100u);

    ASSERT_EQ(scene.instances.size(), 3u);
    EXPECT_EQ(scene.instances[0].name, "table");
    EXPECT_EQ(scene.instances[1].name, "chair_1");
    EXPECT_EQ(scene.instances[2].name, "chair_2");
    EXPECT_EQ(scene.instances[0].entity, 0u);
    EXPECT_EQ(scene.instances[2].entity, 1u);
    EXPECT_EQ(scene.instances[0].placement.translate, Vec3f(0.0f, -1.0f, 0.5f));
    EXPECT_EQ(scene.instances[0].placement.scale, 2.0f);
    EXPECT_LT((scene.instances[0].placement.rotate(Vec3f(0, 0, 1)) - Vec3f(1, 0, 0)).length(), 1e-6f);
    EXPECT_TRUE(is_identity(scene.instances[1].placement.rotate));
}

TEST_F(SceneReader, TakesAnImageRelativeToTheFile) {
    std::string text = valid_scene;
    const std::size_t sky = text.find("sky = ");
    text.replace(sky, text.find('\n', sky) - sky, "image = \"light.exr\"");
    const Result<Scene> scene = read(text);
    ASSERT_TRUE(scene) << scene.error().message();
    EXPECT_EQ(scene->environment.image, folder_ / "light.exr");
    EXPECT_FALSE(scene->environment.sky);
}

TEST_F(SceneReader, GivesEveryInstanceItsOwnName) {
    std::string text = valid_scene;
    text.replace(text.find("[entities.unused]"), 17, "[entities.chair_1]");
    const Result<Scene> scene = read(text + "[[instances]]\nentity = \"chair_1\"\n");
    ASSERT_TRUE(scene) << scene.error().message();
    EXPECT_EQ(scene->instances[1].name, "chair_2");
    EXPECT_EQ(scene->instances[2].name, "chair_3");
    EXPECT_EQ(scene->instances[3].name, "chair_1");
}

TEST_F(SceneReader, NamesOfInstancesInTheFileAreReserved) {
    std::string text = valid_scene;
    text +=
        "name = \"left chair\"\n[[instances]]\nentity = \"chair\"\n[[instances]]\nentity = \"chair\"\n"
        "name = \"table\"\n[[instances]]\nentity = \"unused\"\nname = \"chair_3\"\n";
    const Result<Scene> scene = read(text);
    ASSERT_TRUE(scene) << scene.error().message();
    std::vector<std::string> names;
    for (const Instance& instance : scene->instances) names.push_back(instance.name);
    // The second chair's number is not used, and the third's name is another instance's.
    EXPECT_EQ(names,
              (std::vector<std::string>{"table_1", "chair_1", "left chair", "chair_4", "table", "chair_3"}));
    EXPECT_EQ(scene->instances[2].entity, 1u);
}

TEST_F(SceneReader, RefusesInvalidNamesOfInstances) {
    constexpr const char* second = "[[instances]]\nentity = \"chair\"\n[[instances]]";
    const auto named = [&](const std::string& first, const std::string& name) {
        return message_with(
            second, "[[instances]]\nentity = \"chair\"\n" + first + "name = " + name + "\n[[instances]]");
    };
    EXPECT_EQ(named("", "\"a chair\""), "accepted");
    EXPECT_EQ(named("name = \"a\"\n[[instances]]\nentity = \"table\"\n", "\"a\""),
              "room.toml:47:8: instances[2].name is \"a\", which is the name of instances[1]; expected a "
              "unique name");
    for (const char* name : {"", "a/b", "../a", ".a", "-a"})
        EXPECT_EQ(
            named("", fmt::format("\"{}\"", name)),
            fmt::format("room.toml:44:8: instances[1].name is \"{}\"; expected a valid file name", name));
    EXPECT_EQ(named("", "3"), "room.toml:44:8: instances[1].name is 3; expected a string");
}

TEST_F(SceneReader, ReadsKeyframesAndRefusesInvalidOnes) {
    const std::string first = "[[keyframes]]\ntime = 1\ninstance = \"chair_2\"\ntranslate = [1, 2, 3]\n",
                      second = "[[keyframes]]\ntime = 2.5\ninstance = \"chair_2\"\nrotate = [0, 720, 90]\n",
                      third = "[[keyframes]]\ntime = 3\ninstance = \"chair_2\"\nscale = 0.5\n";
    EXPECT_TRUE(read(valid_scene)->keyframes.empty());
    const Result<Scene> scene = read(first + second + third + valid_scene);
    ASSERT_TRUE(scene) << scene.error().message();
    ASSERT_EQ(scene->keyframes.size(), 3u);
    EXPECT_EQ(scene->keyframes[1].scale, std::nullopt);
    EXPECT_EQ(scene->keyframes[2].scale, 0.5f);
    EXPECT_EQ(scene->keyframes[2].translate, std::nullopt);
    const auto& [one, two] = std::pair(scene->keyframes[0], scene->keyframes[1]);
    EXPECT_EQ(one.time, 1);
    EXPECT_EQ(one.instance, 2u);
    EXPECT_EQ(one.translate, Vec3f(1, 2, 3));
    EXPECT_EQ(one.rotate, std::nullopt);
    EXPECT_EQ(two.time, 2.5f);
    EXPECT_EQ(two.translate, std::nullopt);
    EXPECT_NEAR(two.rotate->y, 4 * pi, 1e-5);
    EXPECT_NEAR(two.rotate->z, pi / 2, 1e-6);

    const auto message = [&](const std::string& text) {
        const Result<Scene> read_back = read(text + valid_scene);
        if (read_back) return std::string("accepted");
        return read_back.error().message().substr(folder_.string().size() + 1);
    };
    EXPECT_EQ(message("[[keyframes]]\ntime = 1\ninstance = \"chair\"\ntranslate = [1, 2, 3]\n"),
              "room.toml:3:12: keyframes[0].instance is \"chair\"; there is no such instance");
    EXPECT_EQ(message(second + first),
              "room.toml:6:8: keyframes[1].time is 1; expected more than 2.5, the time of the previous "
              "keyframe of chair_2");
    EXPECT_EQ(message("[[keyframes]]\ntime = 1\ninstance = \"chair_1\"\n"),
              "room.toml:1:1: keyframes[0] has none of translate, rotate and scale; expected at least one");
    EXPECT_EQ(message("[[keyframes]]\ninstance = \"chair_1\"\nrotate = [1, 2, 3]\n"),
              "room.toml:1:1: keyframes[0].time is missing");
    EXPECT_EQ(message("[[keyframes]]\ntime = -1\ninstance = \"chair_1\"\nrotate = [1, 2, 3]\n"),
              "room.toml:2:8: keyframes[0].time is -1; expected [0, 1000000]");
    EXPECT_EQ(message("[[keyframes]]\ntime = 1\ninstance = \"chair_1\"\nscale = -2\n"),
              "room.toml:4:9: keyframes[0].scale is -2; expected [1e-06, 1000000]");
    EXPECT_EQ(message("[[keyframes]]\ntime = 1\ninstance = \"chair_1\"\nscale = [1, 1, 2]\n"),
              "room.toml:4:9: keyframes[0].scale is a list of 3; expected a number in [1e-06, 1000000]");
    const std::string large = "[[keyframes]]\ntime = 1\ninstance = \"chair_1\"\nscale = 1e6\n";
    EXPECT_EQ(message(large), "accepted");
    EXPECT_EQ(message(std::regex_replace(large, std::regex("chair_1"), "table")),
              "room.toml:4:9: keyframes[0].scale is 1000000, which times the scale of table is 2e+06; "
              "expected 1e-06 to 1e+06");
    EXPECT_EQ(message("keyframes = [1]\n"),
              "room.toml:1:14: keyframes[0] is not a table; expected [[keyframes]]");
}

TEST_F(SceneReader, RequiresALight) {
    std::string text = valid_scene;
    const std::size_t begin = text.find("[environment]"), end = text.find("[materials.lacquer]");
    text.erase(begin, end - begin);
    const auto is_dark = [&](const std::string& scene) {
        const Result<Scene> found = read(scene);
        return !found && found.error().what == "environment is missing";
    };
    EXPECT_TRUE(is_dark(text));
    EXPECT_TRUE(read(text + "[[lights]]\nposition = [0, 2, 0]\n"));
    const auto with_emission = [&](const std::string& emission) {
        std::string glowing = text;
        const std::string cloth = "[materials.cloth]\n";
        return glowing.replace(glowing.find(cloth), cloth.size(), cloth + "emission = " + emission + "\n");
    };
    EXPECT_TRUE(read(with_emission("[0, 2, 0]")));
    EXPECT_TRUE(is_dark(with_emission("[0, 0, 0]")));
}

TEST_F(SceneReader, TakesAnExposureOrLeavesItToBeFound) {
    std::string text = valid_scene;
    text.replace(text.find("exposure = -1.5"), 15, "exposure = \"auto\"");
    const Result<Scene> found = read(text);
    ASSERT_TRUE(found) << found.error().message();
    EXPECT_EQ(found->environment.exposure, std::nullopt);
    text.replace(text.find("exposure = \"auto\""), 17, "");
    EXPECT_EQ(read(text)->environment.exposure, 0.0f);
    EXPECT_EQ(message_with("-1.5", "\"dim\""),
              "room.toml:10:12: environment.exposure is \"dim\"; expected \"auto\" or a number in [-60, 60]");
    EXPECT_EQ(message_with("-1.5", "61"), "room.toml:10:12: environment.exposure is 61; expected [-60, 60]");
}

TEST_F(SceneReader, LeavesTheCameraToBeFoundIfItHasNoPlace) {
    EXPECT_FALSE(read(valid_scene)->finds_camera);
    const std::string scene = valid_scene;
    const auto [start, end] = std::pair(scene.find("position ="), scene.find("vertical_fov"));
    const Result<Scene> lens = read(scene.substr(0, start) + scene.substr(end));
    ASSERT_TRUE(lens) << lens.error().message();
    EXPECT_TRUE(lens->finds_camera);
    EXPECT_EQ(lens->camera.height, 480);
    EXPECT_NEAR(lens->camera.vertical_fov, 35 * pi / 180, 1e-6);
    const Result<Scene> none = read(scene.substr(scene.find("[environment]")));
    ASSERT_TRUE(none) << none.error().message();
    EXPECT_TRUE(none->finds_camera);
    EXPECT_EQ(message_with("target = [0.0, 0.5, 0.0]", ""), "room.toml:1:1: camera.target is missing");
}

TEST_F(SceneReader, TakesAnyAffinePlace) {
    const auto placed = [this](const std::string& keys) {
        std::string text = valid_scene;
        const std::size_t begin = text.find("translate = "), end = text.find("[[instances]]", begin);
        const Result<Scene> scene = read(text.replace(begin, end - begin, keys + "\n"));
        EXPECT_TRUE(scene) << keys << '\n' << scene.error().message();
        return scene->instances[0];
    };
    const auto world = [](const Instance& instance, const Vec3d& point) {
        return instance.placement.point_to_world(instance.shape(point));
    };
    const Instance plain = placed("scale = 0.3\nrotate = [20, -30, 50]\ntranslate = [1, 2, 3]");
    EXPECT_EQ(plain.placement,
              (Placement{{1, 2, 3}, 0.3f, rotation_xyz(Vec3f(20, -30, 50) * float(pi / 180))}));
    EXPECT_EQ(plain.shape, Shape());
    const Instance alike = placed("scale = [0.3, 0.3, 0.3]\nrotate = [20, -30, 50]\ntranslate = [1, 2, 3]");
    EXPECT_EQ(alike.placement, plain.placement) << "to the last bit";
    EXPECT_EQ(alike.shape, Shape());
    const Instance diagonal = placed("matrix = [[0.3, 0, 0, 1], [0, 0.3, 0, 2], [0, 0, 0.3, 3]]");
    EXPECT_EQ(diagonal.placement, (Placement{{1, 2, 3}, 0.3f}));
    EXPECT_EQ(diagonal.shape, Shape());

    const Vec3d point(0.3, -0.7, 1.1);
    const Rotation turn = rotation_xyz(Vec3f(20, -30, 50) * float(pi / 180));
    EXPECT_LT((world(placed("scale = [2, -0.5, 1]\nrotate = [20, -30, 50]\ntranslate = [1, 2, 3]"), point) -
               (turn(Vec3d(0.6, 0.35, 1.1)) + Vec3d(1, 2, 3)))
                  .length(),
              1e-6)
        << "scaled, then turned, then translated";
    EXPECT_LT((world(placed("scale = -2"), point) + point * 2).length(), 1e-6);
    for (const char* last : {"", ", [0, 0, 0, 1.0]"})
        EXPECT_LT((world(placed(std::string("matrix = [[1, 2, 0, -4], [0, 0.5, 3, 5], [0, 0, 1, 6.5]") +
                                last + "]"),
                         point) -
                   Vec3d(0.3 - 1.4 - 4, -0.35 + 3.3 + 5, 1.1 + 6.5))
                      .length(),
                  1e-6);
}

TEST_F(SceneReader, ReadsFinishesAsPovrayMeansThem) {
    const auto lacquer = [this](const std::string& text) {
        std::string scene = valid_scene;
        const std::size_t begin = scene.find("diffuse = [0.25"), end = scene.find("[materials.cloth]");
        const Result<Scene> found = read(scene.replace(begin, end - begin, text + "\n"));
        EXPECT_TRUE(found) << found.error().message();
        return found->materials.at("lacquer");
    };
    const Material full = lacquer(
        "pigment = [0.5, 0.25, 0.1]\nfinish = { diffuse = 0.8, phong = 1.5, phong_size = 60, "
        "specular = 0.2, roughness = 0.01, metallic = 0.7, brilliance = 1 }");
    EXPECT_EQ(full.convention, LobeConvention::povray);
    EXPECT_EQ(full.diffuse, Rgb(0.5f, 0.25f, 0.1f) * 0.8f);
    EXPECT_EQ(full.specular, Rgb(1.0f));
    EXPECT_EQ(full.pigment, Rgb(0.5f, 0.25f, 0.1f));
    EXPECT_EQ(full.phong, 1.5f);
    EXPECT_EQ(full.shininess, 60);
    EXPECT_EQ(full.blinn, 0.2f);
    EXPECT_EQ(full.roughness, 0.01f);
    EXPECT_EQ(full.metallic, 0.7f);
    EXPECT_NEAR(lacquer("pigment = [1.5, 1, 1]\nfinish = {}").diffuse.x, 0.9f, 1e-6f);
    const Material plain = lacquer("pigment = [1, 1, 1]\nfinish = {}");
    const Material without = lacquer("pigment = [1, 1, 1]");
    EXPECT_EQ(without.diffuse, plain.diffuse);
    EXPECT_EQ(without.specular, plain.specular);
    EXPECT_EQ(without.convention, LobeConvention::povray);
    EXPECT_EQ(plain.diffuse, Rgb(0.6f)) << "POV-Ray's default";
    EXPECT_EQ(plain.specular, Rgb(0.0f));
    const Material shiny = lacquer("pigment = [1, 1, 1]\nfinish = { phong = 0.3, specular = 0.3 }");
    EXPECT_EQ(shiny.shininess, 40) << "POV-Ray's defaults";
    EXPECT_EQ(shiny.roughness, 0.05f);
    EXPECT_EQ(shiny.metallic, 0);
}

TEST_F(SceneReader, KeepsLightThatIsOnlyVisible) {
    const Result<Scene> plain = read(valid_scene);
    ASSERT_TRUE(plain);
    EXPECT_TRUE(plain->environment.lights);
    EXPECT_FALSE(plain->bounces);
    Scene scene = *plain;
    scene.environment.lights = false;
    scene.bounces = 3;
    scene.lamps.emplace_back();
    scene.lamps.back().name = "lamp";
    scene.lamps.back().position = Vec3f(0, 5, 0);
    scene.materials.at("cloth").ambient = Rgb(0.25f, 0.5f, 0.125f);
    SceneMaterial& finished = scene.materials.at("lacquer");
    finished = {};
    finished.convention = LobeConvention::povray;
    finished.pigment = Rgb(0.5f);
    finished.diffuse = Rgb(0.25f);
    finished.ambient = Rgb(0.125f);
    const Result<Scene> again = read(scene_text(scene, folder_));
    ASSERT_TRUE(again) << again.error().message();
    EXPECT_FALSE(again->environment.lights);
    EXPECT_EQ(again->bounces, 3);
    EXPECT_EQ(again->materials.at("cloth").ambient, Rgb(0.25f, 0.5f, 0.125f));
    EXPECT_EQ(again->materials.at("cloth").emission, Rgb(0.0f));
    EXPECT_EQ(again->materials.at("lacquer").ambient, Rgb(0.125f));
}

TEST_F(SceneReader, ErrorsNameThePlaceTheFoundAndTheExpectedValue) {
    EXPECT_EQ(message_with("vertical_fov = 35.0", "vertical_fov = 190"),
              "room.toml:4:16: camera.vertical_fov is 190; expected [0.01, 179]");
    EXPECT_EQ(message_with("vertical_fov", "fov"),
              "room.toml:4:1: camera.fov is not known; expected one of: position, resolution, target, "
              "vertical_fov");
    EXPECT_EQ(message_with("entity = \"chair\"", "entity = \"stool\""),
              "room.toml:43:10: instances[1].entity is \"stool\"; there is no such entity");
}

TEST_F(SceneReader, RefusesInvalidScenes) {
    constexpr const char* cloth = "diffuse = [1, 0, 0.5]";
    constexpr const char* place = "translate = [0.0, -1, 0.5]\nscale = 2\nrotate = [0, 90, 0]";
    struct Case {
        const char *from, *to, *message;
    };
    for (const auto& [from, to, message] : {
             // not TOML
             Case{"[camera]", "[camera", "1:8: "},
             Case{"turbidity = 3,", "turbidity = 3, turbidity = 4,", "8:"},
             // unknown and missing keys
             Case{"[camera]", "colour = 1\n[camera]", "1:1: colour is not known"},
             Case{"turbidity", "haze", "8:9: environment.sky.haze is not known"},
             Case{"shininess", "gloss", "15:1: materials.lacquer.gloss is not known"},
             Case{"fine_vertices", "vertices", "24:1: entities.table.vertices is not known"},
             Case{"scale = 2", "size = 2", "40:1: instances[0].size is not known"},
             Case{"position = [3.2, 1.8, 4]", "", "1:1: camera.position is missing"},
             Case{"mesh = \"box.obj\"", "", "20:1: entities.table.mesh is missing"},
             Case{"entity = \"table\"", "", "37:1: instances[0].entity is missing"},
             Case{"[environment]\nsky", "[surroundings]\nsky", "7:2: surroundings is not known"},
             // wrong types
             Case{"[3.2, 1.8, 4]", "\"here\"", "2:12: camera.position is \"here\"; expected 3 numbers"},
             Case{"[3.2, 1.8, 4]", "[3.2, 1.8]", "2:12: camera.position is a list of 2; expected 3 numbers"},
             Case{"[3.2, 1.8, 4]", "[3.2, true, 4]", "2:18: camera.position[1] is true; expected a number"},
             Case{"[640, 480]", "[640.0, 480]", "5:15: camera.resolution[0] is 640; expected a whole number"},
             Case{"25000", "25000.0",
                  "24:17: entities.table.fine_vertices is 25000; expected a whole number"},
             Case{"\"lacquer\"\nmaterials", "3\nmaterials",
                  "22:12: entities.table.material is 3; expected a string"},
             Case{"{ seat = \"cloth\" }", "[1]",
                  "23:13: entities.table.materials is a list of 1; expected a table"},
             Case{"-1.5", "1979-05-27", "10:12: environment.exposure is a date or time; expected a number"},
             // not finite, out of range
             Case{"[3.2, 1.8, 4]", "[nan, 1.8, 4]",
                  "2:13: camera.position[0] is nan; expected [-1000000, 1000000]"},
             Case{"scale = 2", "scale = inf", "40:9: instances[0].scale is inf"},
             Case{"scale = 2", "scale = 0",
                  "40:9: instances[0].scale is 0; expected [1e-06, 1000000] with either sign"},
             Case{"scale = 2", "scale = -1e7", "40:9: instances[0].scale is -10000000"},
             Case{"scale = 2", "scale = [1, 2]",
                  "40:9: instances[0].scale is a list of 2; expected a number or 3 numbers in [1e-06,"},
             Case{"scale = 2", "scale = [1, 2, 0]", "40:16: instances[0].scale[2] is 0; expected [1e-06,"},
             Case{"scale = 2", "scale = [1, \"2\", 1]", "40:13: instances[0].scale[1] is \"2\"; expected"},
             Case{"scale = 2", "scale = [1, 1e-5, 1]",
                  "40:9: instances[0].scale has scale factors from 1e-05 to 1; expected"},
             Case{"scale = 2", "matrix = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]",
                  "39:13: instances[0].translate conflicts with matrix; expected either a matrix, or"},
             Case{place, "matrix = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]",
                  "39:10: instances[0].matrix is a list of 12; expected 3 rows of 4 numbers in [-1000000,"},
             Case{place, "matrix = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]",
                  "39:11: instances[0].matrix[0] is a list of 3; expected 4 numbers"},
             Case{place, "matrix = [[1, 0, 0, 0], [0, 1, nan, 0], [0, 0, 1, 0]]",
                  "39:32: instances[0].matrix[1][2] is nan; expected [-1000000, 1000000]"},
             Case{place, "matrix = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 2, 0, 1]]",
                  "39:53: instances[0].matrix[3] is 0 2 0 1; expected 0 0 0 1"},
             Case{place, "matrix = [[1, 2, 0, 0], [2, 4, 0, 0], [0, 0, 1, 0]]",
                  "39:10: instances[0].matrix has scale factors from"},
             Case{"scale = 2", "scale = nan", "40:9: instances[0].scale is nan"},
             Case{"[640, 480]", "[640, 0]", "5:20: camera.resolution[1] is 0; expected [1, 16384]"},
             Case{"[640, 480]", "[16385, 480]", "5:15: camera.resolution[0] is 16385"},
             Case{"turbidity = 3", "turbidity = 1.9",
                  "8:21: environment.sky.turbidity is 1.9; expected [2, 10]"},
             Case{"sun_elevation = 40", "sun_elevation = 91", "8:40: environment.sky.sun_elevation is 91"},
             Case{"sun_angular_radius = 0.5", "sun_angular_radius = 0", "expected (0, 5.7]"},
             Case{"[0.25, 0.08, 0.04]", "[0.25, 1.08, 0.04]", "13:18: materials.lacquer.diffuse[1] is 1.08"},
             Case{"[0.3, 0.3, 0.3]", "[0.3, -0.1, 0.3]", "14:18: materials.lacquer.specular[1] is -0.1"},
             Case{"shininess = 60", "shininess = 0.5",
                  "15:13: materials.lacquer.shininess is 0.5; expected [1, 1000]"},
             Case{cloth, "finish = {}", "17:1: materials.cloth.pigment is missing"},
             Case{cloth, "diffuse = [1, 0, 0.5]\nfinish = {}",
                  "18:11: materials.cloth.diffuse conflicts with pigment and finish; expected either these, "
                  "or"},
             Case{cloth, "pigment = [1, 0, 0.5]\nfinish = { brilliance = 2 }",
                  "19:25: materials.cloth.finish.brilliance is 2; expected 1"},
             Case{cloth, "pigment = [1, 0, 0.5]\nfinish = { crand = 0.1 }",
                  "19:12: materials.cloth.finish.crand is not known"},
             Case{cloth, "pigment = [1, 0, 0.5]\nfinish = { roughness = 0.0001 }",
                  "19:24: materials.cloth.finish.roughness is 0.0001; expected [0.0005, 1]"},
             Case{cloth, "pigment = [1, 0, 0.5]\nfinish = { metallic = 1.5 }",
                  "19:23: materials.cloth.finish.metallic is 1.5; expected [0, 1]"},
             Case{cloth, "pigment = [1, 0, 200]\nfinish = {}",
                  "18:18: materials.cloth.pigment[2] is 200; expected [0, 100]"},
             Case{cloth, "pigment = [1, 0, 2]\nfinish = {}",
                  "18:11: materials.cloth: pigment times finish.diffuse is 1.2; expected at most 1"},
             Case{cloth, "pigment = [1, 0, 1.5]\nfinish = { metallic = 1 }",
                  "18:11: materials.cloth: the pigment of a metallic finish is 1.5; expected at most 1"},
             Case{"25000", "0", "24:17: entities.table.fine_vertices is 0; expected [1, 20000000]"},
             Case{"25000", "20000001", "24:17: entities.table.fine_vertices is 20000001"},
             Case{"= 200", "= 0", "26:18: entities.table.planar_samples is 0; expected [1, 10000000]"},
             Case{"= 100\n", "= -100\n", "27:21: entities.table.spherical_samples is -100"},
             Case{"coarse_triangles = 0", "coarse_triangles = -1",
                  "25:20: entities.table.coarse_triangles is -1"},
             Case{"[0.0, 0.5, 0.0]", "[3.2, 1.8, 4.0]", "3:10: camera.target equals camera.position"},
             // unknown names, missing files
             Case{"\"povray\"", "\"blinn\"",
                  "16:14: materials.lacquer.convention is \"blinn\"; expected \"physical\""},
             Case{"material = \"lacquer\"", "material = \"gold\"",
                  "22:12: entities.table.material is \"gold\""},
             Case{"seat = \"cloth\"", "seat = \"silk\"", "23:22: entities.table.materials.seat is \"silk\""},
             Case{"\"box.obj\"", "\"missing.obj\"", "21:8: entities.table.mesh is"},
             Case{"\"box.obj\"", "\"\"", "21:8: entities.table.mesh is not a valid file name"},
             Case{"\"box.obj\"", "\".\"", "21:8: entities.table.mesh is"},
             Case{"\"box.obj\"", "\"box.obj\\u0000\"", "21:8: entities.table.mesh is not a valid file name"},
             Case{"entities.table", "entities.\"../table\"",
                  "found an invalid entity name; expected a valid file name"},
             // environment and instances
             Case{"rotation = 90", "image = \"light.exr\"", "environment has both image and sky"},
             Case{"rotation = 90", "image = \"dark.exr\"", "9:9: environment.image is"},
         }) {
        const std::string found = message_with(from, to);
        EXPECT_TRUE(found.starts_with("room.toml:") && found.find(message) != std::string::npos)
            << from << " -> " << to << "\n  found:  " << found << "\n  wanted: " << message;
    }
    std::string without_sky = valid_scene;
    without_sky.erase(without_sky.find("sky = "), without_sky.find("rotation") - without_sky.find("sky = "));
    EXPECT_FALSE(read(without_sky));
    const std::string without_instances(valid_scene, std::string(valid_scene).find("[[instances]]"));
    EXPECT_FALSE(read(without_instances));
    EXPECT_FALSE(read("instances = []\n" + without_instances));
    EXPECT_FALSE(read("instances = [1]\n" + without_instances));
}

TEST_F(SceneReader, RefusesNumbersThatAreNotFiniteForEveryKey) {
    struct Table {
        std::string header;
        std::map<std::string, std::string> keys;
    };
    const std::vector<Table> tables{
        {"[camera]", {{"position", "[0, 1, 4]"}, {"target", "[0, 0, 0]"}}},
        {"[environment]", {}},
        {"[environment.sky]", {}},
        {"[materials.lacquer]", {}},
        {"[materials.cloth]", {{"pigment", "[1, 1, 1]"}}},
        {"[materials.cloth.finish]", {}},
        {"[entities.table]", {{"mesh", "\"box.obj\""}, {"material", "\"cloth\""}}},
        {"[[instances]]", {{"entity", "\"table\""}}},
        {"[[keyframes]]", {{"time", "1"}, {"instance", "\"table\""}, {"translate", "[0, 0, 0]"}}}};
    const auto message_with_key = [&](std::size_t changed, const std::string& key, const std::string& value) {
        std::vector<Table> all = tables;
        all[changed].keys[key] = value;
        std::string text;
        for (const auto& [header, keys] : all) {
            text += header + '\n';
            for (const auto& [name, content] : keys) text += name + " = " + content + '\n';
        }
        const Result<Scene> scene = read(text);
        return scene ? std::string() : scene.error().message();
    };
    EXPECT_EQ(message_with_key(0, "vertical_fov", "30"), "");
    int numbers = 0;
    for (std::size_t t = 0; t < tables.size(); ++t) {
        // The reader's error lists the valid keys.
        const std::string unknown = message_with_key(t, "unknown", "1"), wanted = "expected one of: ";
        ASSERT_NE(unknown.find(wanted), std::string::npos) << unknown;
        std::istringstream keys(unknown.substr(unknown.find(wanted) + wanted.size()));
        for (std::string key; std::getline(keys >> std::ws, key, ',');) {
            if (key == "sky" || key == "finish") continue;  // tables of their own
            for (const std::string value : {"nan", "inf", "-inf"}) {
                // One to three values, because the key determines their number.
                std::string list = value, message;
                for (int n = 1; n <= 3; ++n, list += ", " + value) {
                    message = message_with_key(t, key, n == 1 ? value : "[" + list + "]");
                    EXPECT_NE(message.find("." + key), std::string::npos)
                        << key << " = " << value << ": " << message;
                    EXPECT_NE(message.find("; expected "), std::string::npos)
                        << key << " = " << value << ": " << message;
                    for (const char* range : {"[", "(", "a whole number in ["})
                        numbers +=
                            message.find(std::string(" is nan; expected ") + range) != std::string::npos;
                }
            }
        }
    }
    EXPECT_GE(numbers, 24);
}

TEST_F(SceneReader, RefusesMissingAndIrregularFiles) {
    EXPECT_FALSE(read_scene(folder_ / "missing.toml"));
    EXPECT_FALSE(read_scene(folder_));
    EXPECT_FALSE(read_scene(""));
    EXPECT_FALSE(read(""));
    EXPECT_FALSE(read(std::string(100, '\0')));
    const Result<Scene> large = read(std::string(valid_scene) + std::string(16 << 20, '\n'));
    ASSERT_FALSE(large);
    EXPECT_NE(large.error().message().find("larger than 16 MiB"), std::string::npos)
        << large.error().message();
}

TEST_F(SceneReader, RefusesNestingThatWouldOverflowTheStack) {
    std::string dots = "a";
    for (int i = 0; i < 1'000'000; ++i) dots += ".a";
    EXPECT_FALSE(read(dots + " = 1"));
    EXPECT_FALSE(read("[" + dots + "]"));
    EXPECT_FALSE(read("a = " + std::string(1'000'000, '[')));
    std::string tables = "a = ";
    for (int i = 0; i < 100'000; ++i) tables += "{a = ";
    EXPECT_FALSE(read(tables));
    // Dots in comments are no keys.
    EXPECT_TRUE(read("# " + std::string(1000, '.') + "\n" + valid_scene));
}

TEST_F(SceneReader, TakesLettersBeyondAsciiInQuotesAndComments) {
    std::string text = valid_scene;
    text.replace(text.find("[entities.unused]"), 17, "[entities.\"ge\xC3\xA4ndert\"]  # \xE2\x80\xA6");
    const Result<Scene> scene = read("\xEF\xBB\xBF" + text);
    ASSERT_TRUE(scene) << scene.error().message();
    EXPECT_EQ(scene->entities[2].name, "ge\xC3\xA4ndert");
    EXPECT_NE(message_with("[entities.unused]", "[entities.ge\xC3\xA4ndert]")
                  .find("33:13: found a non-ASCII character"),
              std::string::npos);
}

TEST_F(SceneReader, SurvivesAFileCutShortAnywhere) {
    const std::string text = valid_scene;
    int accepted = 0;
    for (std::size_t length = 0; length <= text.size(); ++length)
        accepted += read(text.substr(0, length)) ? 1 : 0;
    // Texts that end in or after the first, the second and the third instance are valid, if the instance has
    // its entity.
    EXPECT_GE(accepted, 3);
    EXPECT_LT(accepted, 200);
}

TEST_F(SceneReader, SurvivesChangedBytes) {
    std::mt19937 random(2006);
    const std::string syntax = ",=[]{}\"'#.\n 0e-+_";
    for (int i = 0; i < 2000; ++i) {
        std::string text = valid_scene;
        for (int changes = 1 + i % 4; changes > 0; --changes)
            text[random() % text.size()] =
                i % 2 == 0 ? syntax[random() % syntax.size()] : static_cast<char>(random());
        const Result<Scene> scene = read(text);
        if (!scene) {
            EXPECT_FALSE(scene.error().what.empty());
        }
    }
}

}  // namespace
}  // namespace haarfield
