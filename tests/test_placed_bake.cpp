#include "bridge/povray/placed_bake.h"
#include "bridge/povray_import/light_probe.h"
#include "bridge/povray_import/models_in_scene.h"
#include "fields/file/input_file.h"
#include "fields/file/write_file.h"
#include "scenes/image.h"
#include "scenes/scene_reader.h"
#include "scenes/scene_writer.h"
#include "tests/fixtures/bridge_fixtures.h"
#include "tests/fixtures/test_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace haarfield {
namespace {

constexpr const char* box_obj =
    "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\nv 0 2 0\nv 1 2 0\nv 1 2 1\nv 0 2 1\n"
    "f 1 2 3 4\nf 8 7 6 5\nf 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 4 8 5 1\n";

/// A scene in POV-Ray's usual frame: +y up, +z away from the camera.
constexpr const char* left_handed =
    "#version 3.7;\nglobal_settings{assumed_gamma 1}\ncamera{location <0,1,-9> look_at <0,1,0> angle 50}\n"
    "background{rgb <.1,.2,.4>}\nlight_source{<40,50,-60> rgb <1,.5,.25>}\n";

class PlacedBakeTest : public testing::Test {
protected:
    std::filesystem::path write(const std::string& name, const std::string& text) const {
        EXPECT_TRUE(write_file(folder_.path() / name, text));
        return folder_.path() / name;
    }

    /// Imports a box of 1 x 2 x 1 into a scene.
    Result<ModelsInScene> placed(const std::string& scene, const Vec3d& at) const {
        PlaceInScene place;
        place.file = write("scene.pov", scene);
        place.at = at;
        place.width = 64;
        const std::filesystem::path box = write("box.obj", box_obj);
        return models_in_scene({&box, 1}, place, folder_.path() / "out/box_light.exr");
    }

    TestFolder folder_;
};

TEST_F(PlacedBakeTest, ModelsStandAtTheirPlaceInTheLightOfTheScene) {
    const Result<ModelsInScene> models = placed(left_handed, Vec3d(3, 0.5, 2));
    ASSERT_TRUE(models) << models.error().message();
    const Scene& scene = models->scene;
    // The middle of the bottom of the box is at <3, .5, 2>, which is (3, .5, -2) here.
    ASSERT_EQ(scene.instances.size(), 1u);
    EXPECT_LT((scene.instances[0].placement.translate - Vec3f(2.5f, 0.5f, -2.5f)).length(), 1e-5f);
    EXPECT_LT((models->probe - Vec3d(3, 1.5, 2)).length(), 1e-5);
    ASSERT_TRUE(scene.surroundings);
    EXPECT_TRUE(scene.surroundings->left_handed);
    EXPECT_FALSE(scene.surroundings->z_up);
    EXPECT_FALSE(scene.finds_camera);
    EXPECT_LT((scene.camera.position - Vec3f(0, 1, 9)).length(), 1e-4f);
    ASSERT_EQ(scene.lamps.size(), 1u);
    EXPECT_LT((scene.lamps[0].position - Vec3f(40, 50, 60)).length(), 1e-4f);
    EXPECT_NEAR(scene.lamps[0].colour.y, 0.5, 0.01);
    EXPECT_LT(models->corner_difference, 0.001);  // Nothing is nearby.
    const Result<Image> light = read_image(scene.environment.image);
    ASSERT_TRUE(light) << light.error().message();
    for (const Rgb& pixel : light->pixels) EXPECT_NEAR(pixel.z, 0.4, 1e-3);  // Without the light.
}

TEST_F(PlacedBakeTest, CornersReportWhatIsNotDistant) {
    const std::string wall =
        "box{<-5,-5,3.2>,<5,5,4> pigment{rgb 1} finish{ambient 0 emission 2 diffuse 0}}\n";
    const Result<ModelsInScene> near = placed(left_handed + wall, Vec3d(0, 0, 2));
    ASSERT_TRUE(near) << near.error().message();
    EXPECT_GT(near->corner_difference, 0.03);
    EXPECT_GT(near->largest_corner_difference, near->corner_difference);
    // Half of the box is in the shadow of a screen.
    const std::string screen = "box{<-50,-50,-2>,<0,50,-1.9> pigment{rgb 0} no_image}\n";
    const Result<ModelsInScene> shaded =
        placed(std::string("light_source{-1e5*z rgb 5}\n") + left_handed + screen, Vec3d(0, 0, 0));
    ASSERT_TRUE(shaded) << shaded.error().message();
    EXPECT_GT(shaded->corner_difference, 0.3);
}

TEST_F(PlacedBakeTest, ModelsShadeTheSurroundings) {
    const std::string floor = "plane{y,0 pigment{rgb 1} finish{ambient 0 diffuse 1}}\n",
                      above = "light_source{<0,1000,0> rgb 1}\n";
    const Result<ModelsInScene> models =
        placed("#version 3.7;\nglobal_settings{assumed_gamma 1}\ncamera{location -9*z}\n" + above + floor,
               Vec3d(0, 0.1, 0));
    ASSERT_TRUE(models) << models.error().message();
    const Result<Image> light = read_image(models->scene.environment.image);
    ASSERT_TRUE(light);
    const std::size_t below = std::size_t(light->width) * std::size_t(light->height - 1);
    EXPECT_LT(light->pixels[below].x, 0.01f);
    const std::size_t aside = std::size_t(light->width) * std::size_t(light->height * 5 / 8);
    EXPECT_GT(light->pixels[aside].x, 0.9f);
}

TEST_F(PlacedBakeTest, AssumedGammaDoesNotChangeTheNumbers) {
    const Result<ModelsInScene> models = placed(
        "#version 3.6;\nglobal_settings{assumed_gamma 2.2}\ncamera{location -9*z}\nbackground{rgb .5}\n",
        Vec3d(0, 0, 0));
    ASSERT_TRUE(models) << models.error().message();
    const Result<Image> light = read_image(models->scene.environment.image);
    ASSERT_TRUE(light);
    EXPECT_NEAR(light->pixels[7].x, 0.5, 1e-3);
    EXPECT_TRUE(std::ranges::any_of(models->warnings, [](const std::string& warning) {
        return warning.find("assumed_gamma 2.2") != std::string::npos;
    }));
}

TEST_F(PlacedBakeTest, PlacesWithoutLightAreErrors) {
    const Result<ModelsInScene> models = placed(
        "#version 3.7;\nglobal_settings{assumed_gamma 1}\ncamera{location -9*z}\n"
        "sphere{0,20 pigment{rgb 1} finish{ambient 0}}\n",
        Vec3d(0, 0, 0));
    ASSERT_FALSE(models);
    EXPECT_NE(models.error().message().find("no light reaches 0,1,0"), std::string::npos)
        << models.error().message();
}

TEST_F(PlacedBakeTest, TransmittancesHaveShadowsAndFilters) {
    const std::filesystem::path file =
        write("scene.pov",
              "#version 3.7;\nglobal_settings{assumed_gamma 2.2}\ncamera{location -9*z}\n"
              "light_source{<0,100,0> rgb <1,.5,2>}\nlight_source{<100,0,0> rgb 7}\n"
              "box{<-1,5,-1>,<1,6,1> pigment{rgb 1}}\nbox{<9,5,-1>,<11,6,1> pigment{rgbf <1,.5,0,1>}}\n");
    const Result<SceneQueries> queries = SceneQueries::create(file, {});
    ASSERT_TRUE(queries) << queries.error().message();
    const Result<SceneSurvey> survey = scene_survey(*queries);
    ASSERT_TRUE(survey) << survey.error().message();
    std::vector<LitPlace> samples;
    for (const double x : {0.0, 10.0, 20.0})
        for (const std::size_t light : {0u, 1u}) samples.push_back({Vec3d(x, 0, 0), light});
    const auto fractions = light_transmittances(*queries, *survey, samples, 0.05, /*without_gamma=*/true);
    ASSERT_TRUE(fractions) << fractions.error().message();
    const std::vector<Rgb> expected{Rgb(0), Rgb(1), Rgb(1, 0.25f, 0), Rgb(1), Rgb(1), Rgb(1)};
    for (std::size_t i = 0; i < expected.size(); ++i)
        EXPECT_LT(((*fractions)[i] - expected[i]).length(), 0.02f) << i << ": " << (*fractions)[i];
}

/// A bake of a green square, placed in scenes whose frames differ, appears where the scene puts it.
TEST_F(PlacedBakeTest, ObjectsAppearAtTheirPlaceInEitherFrame) {
    Mesh mesh;
    // In the frame of a baked scene: at x = 2, y = 1, z = 0, facing +z.
    mesh.positions = {{1.5f, 0.5f, 0}, {2.5f, 0.5f, 0}, {2.5f, 1.5f, 0}, {1.5f, 1.5f, 0}};
    mesh.normals.assign(4, Vec3f(0, 0, 1));
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.vertex_materials.assign(4, 0);
    const std::vector<Rgb> radiance(4, Rgb(0, 1, 0));
    const BakedInstance instance{"Square", &mesh, {}, radiance};
    struct Frame {
        const char* camera;
        bool z_up, left_handed;
    };
    for (const Frame& frame :
         {Frame{"location <0,0,-6> look_at 0 right x", false, true},
          Frame{"location <0,0,6> look_at 0 right -x", false, false},
          Frame{"direction y sky z location <0,6,0> look_at 0 up z right -x", true, true},
          Frame{"direction y sky z location <0,-6,0> look_at 0 up z right x", true, false}}) {
        write("user.pov", std::string("#version 3.7;\nglobal_settings{assumed_gamma 1}\ncamera{") +
                              frame.camera + " angle 90}\nbackground{rgb x}\n");
        const std::filesystem::path out = folder_.path() / "out";
        const Result<BakedFiles> files =
            write_baked_scene(out, "one", frontal_camera(6, 32), {&instance, 1}, {});
        ASSERT_TRUE(files) << files.error().message();
        const Surroundings surroundings{folder_.path() / "user.pov", frame.z_up, frame.left_handed};
        const Result<PlacedBake> placed =
            write_placed_bake(out, "one", *files, frontal_camera(6, 32), surroundings);
        ASSERT_TRUE(placed) << placed.error().message();
        EXPECT_EQ(placed->object, "One_Baked");
        const std::filesystem::path png = out / "in_place.png";
        const Result<Done> rendered =
            render_sandboxed(placed->scene, {out, folder_.path()}, png, {"+W48", "+H48", "-A"}, {});
        ASSERT_TRUE(rendered) << frame.camera << rendered.error().message();
        const Result<Image> image = read_image(png);
        ASSERT_TRUE(image) << image.error().message();
        // 12 units across: x = 2, y = 1 is 8 pixels to the right of the middle and 4 above it.
        double column = 0, row = 0, count = 0;
        for (int y = 0; y < 48; ++y)
            for (int x = 0; x < 48; ++x)
                if (image->pixels[std::size_t(y * 48 + x)].y > 0.5f) {
                    column += x + 0.5;
                    row += y + 0.5;
                    count += 1;
                }
        ASSERT_GT(count, 8) << frame.camera;
        EXPECT_NEAR(column / count, 24 + 8, 0.6) << frame.camera;
        EXPECT_NEAR(row / count, 24 - 4, 0.6) << frame.camera;
    }
}

TEST_F(PlacedBakeTest, OneIncludePlacesAllInstances) {
    const Mesh mesh = upright_square_mesh(1, 1);
    const std::vector<Rgb> radiance(mesh.positions.size(), Rgb(1));
    std::vector<BakedInstance> instances{{"a", &mesh, {}, radiance}, {"Baked", &mesh, {}, radiance}};
    instances[0].placement.translate = Vec3f(-1, 0, 0);
    instances[1].placement.translate = Vec3f(1, 0, 0);
    const Camera camera = frontal_camera(6, 32);
    const Result<BakedFiles> files = write_baked_scene(folder_.path(), "two", camera, instances, {});
    ASSERT_TRUE(files) << files.error().message();
    const Result<PlacedBake> placed = write_placed_bake(folder_.path(), "two", *files, camera, {});
    ASSERT_TRUE(placed) << placed.error().message();
    EXPECT_NE(placed->object, "Two_Baked");  // The name of an instance.
    EXPECT_TRUE(placed->scene.empty());
    const std::filesystem::path scene =
        write("own.pov",
              "#version 3.7;\nglobal_settings{assumed_gamma 1 adc_bailout 0}\n"
              "camera{location 6*z look_at 0 right -x angle 90}\n#include \"" +
                  placed->include.filename().string() + "\"\nobject{" + placed->object + "}\n");
    const std::filesystem::path png = folder_.path() / "own.png";
    const Result<Done> rendered = render_sandboxed(scene, {folder_.path()}, png, {"+W48", "+H48", "-A"}, {});
    ASSERT_TRUE(rendered) << rendered.error().message();
    const Result<Image> image = read_image(png);
    ASSERT_TRUE(image);
    EXPECT_GT(image->pixels[24 * 48 + 20].y, 0.5f);
    EXPECT_GT(image->pixels[24 * 48 + 28].y, 0.5f);
    EXPECT_LT(image->pixels[24 * 48 + 24 + 10].y, 0.5f);
}

TEST_F(PlacedBakeTest, SceneFilesKeepTheirSurroundings) {
    const std::filesystem::path user = write("user.pov", left_handed);
    write("box.obj", box_obj);
    const std::string start =
        "[entities.box]\nmesh = \"box.obj\"\n[[instances]]\nentity = \"box\"\n"
        "[environment]\nsky = {}\n[povray]\n";
    const auto read = [&](const std::string& keys) { return read_scene(write("box.toml", start + keys)); };
    const Result<Scene> scene = read(
        "scene = \"user.pov\"\nup = \"z\"\nhandedness = \"right\"\nfolder = \".\"\n"
        "[[filters]]\nmesh = \"box.obj\"\ncolour = [0.5, 1, 0]\n"
        "absorption = [1, 0, 3]\nvertex_colours = true\n");
    ASSERT_TRUE(scene) << scene.error().message();
    ASSERT_TRUE(scene->surroundings);
    EXPECT_TRUE(scene->surroundings->z_up);
    EXPECT_FALSE(scene->surroundings->left_handed);
    const Result<Scene> again = read_scene(write("again.toml", scene_text(*scene, folder_.path())));
    ASSERT_TRUE(again) << again.error().message();
    ASSERT_TRUE(again->surroundings);
    EXPECT_TRUE(again->surroundings->z_up);
    EXPECT_FALSE(again->surroundings->left_handed);
    EXPECT_TRUE(std::filesystem::equivalent(again->surroundings->file, user));
    EXPECT_TRUE(std::filesystem::equivalent(again->surroundings->folder, folder_.path()));
    ASSERT_EQ(again->filters.size(), 1u);
    EXPECT_TRUE(std::filesystem::equivalent(again->filters[0].mesh, folder_ / "box.obj"));
    EXPECT_EQ(again->filters[0].colour, Rgb(0.5f, 1, 0));
    EXPECT_EQ(again->filters[0].absorption, Rgb(1, 0, 3));
    EXPECT_TRUE(again->filters[0].vertex_colours);
    const Result<Scene> usual = read("scene = \"user.pov\"\n");
    ASSERT_TRUE(usual) << usual.error().message();
    EXPECT_TRUE(usual->surroundings->left_handed && !usual->surroundings->z_up);
    for (const auto& [keys, message] :
         {std::pair("", "povray.scene is missing"),
          {"scene = \"missing.pov\"\n", "missing.pov"},
          {"scene = \"user.pov\"\nup = \"x\"\n", "povray.up is \"x\"; expected \"y\" or \"z\""},
          {"scene = \"user.pov\"\nhandedness = 1\n", "povray.handedness"},
          {"scene = \"user.pov\"\nfolder = \"user.pov\"\n", "there is no such folder"},
          {"scene = \"user.pov\"\n[[filters]]\ncolour = [1, 1, 1]\n", "filters[0].mesh is missing"},
          {"scene = \"user.pov\"\n[[filters]]\nmesh = \"box.obj\"\ncolour = [2, 1, 1]\n",
           "filters[0].colour"}}) {
        const Result<Scene> wrong = read(keys);
        ASSERT_FALSE(wrong) << keys;
        EXPECT_NE(wrong.error().message().find(message), std::string::npos) << wrong.error().message();
    }
}

/// A green mirror on the ground below a red ball, in POV-Ray's scene.
class ReflectionTest : public PlacedBakeTest {
protected:
    /// Renders the mirror straight from above, and returns the pixel of the ball's image and one beside it.
    std::array<Rgb, 2> rendered(const Reflection& reflection, bool has_image, bool shows_reflection = true) {
        Mesh mesh;
        mesh.positions = {{-1, 0, 1}, {1, 0, 1}, {1, 0, -1}, {-1, 0, -1}};
        mesh.normals.assign(4, Vec3f(0, 1, 0));
        mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
        mesh.vertex_materials.assign(4, 0);
        mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
        Surface surface;
        surface.reflection = reflection;
        if (has_image) {
            Texture white;
            white.name = "white";
            white.width = white.height = 2;
            white.texels.assign(4, {255, 255, 255, 255});
            surface.texture = std::make_shared<const Texture>(white);
        }
        const std::vector<Rgb> radiance(4, Rgb(0, 0.25f, 0));
        BakedInstance instance{"Mirror", &mesh, {}, radiance, {}, {&surface, 1}};
        instance.shows_reflection = shows_reflection;
        const Result<BakedFiles> files =
            write_baked_scene(folder_.path(), "m", frontal_camera(6, 32), {&instance, 1}, {});
        EXPECT_TRUE(files) << files.error().message();
        const std::filesystem::path scene =
            write("mirror.pov",
                  "#version 3.7;\nglobal_settings{assumed_gamma 1 adc_bailout 0}\n#include \"m_Mirror.inc\"\n"
                  "camera{location 5*y look_at 0 up z right -x angle 40}\nobject{M_Mirror}\n"
                  "sphere{10*y+1.5*x,1.5 pigment{rgb x} finish{emission 1 ambient 0 diffuse 0}}\n");
        const std::filesystem::path png = folder_.path() / "mirror.png";
        const Result<Done> done = render_sandboxed(scene, {folder_.path()}, png, {"+W64", "+H64", "-A"}, {});
        EXPECT_TRUE(done) << done.error().message();
        const Result<Image> image = read_image(png);
        EXPECT_TRUE(image);
        std::array<Rgb, 2> pixels{Rgb(0), Rgb(0)};
        for (const Rgb& pixel : image->pixels) {
            if (pixel.x > pixels[0].x) pixels[0] = pixel;
            if (pixel.y > 0 && pixel.x == 0) pixels[1] = pixel;
        }
        return pixels;
    }
};

TEST_F(ReflectionTest, MirrorsShowTheSceneOverTheBakedLight) {
    for (const bool has_image : {false, true}) {
        const Reflection mirror{Rgb(0.4f), Rgb(0.4f)};
        const auto [ball, aside] = rendered(mirror, has_image);
        EXPECT_LT((ball - Rgb(0.4f, 0.25f, 0)).length(), 0.01f) << has_image << ball;
        EXPECT_LT((aside - Rgb(0, 0.25f, 0)).length(), 0.01f) << has_image << aside;
        const auto [glass, beside] = rendered({Rgb(0), Rgb(1), 1.5f}, has_image);
        EXPECT_NEAR(glass.x, 0.04f, 0.005f) << has_image;  // ((1.5 - 1) / (1.5 + 1))^2
        const auto [none, everywhere] = rendered(mirror, has_image, false);
        EXPECT_EQ(none.x, 0) << has_image;
    }
}

TEST_F(ReflectionTest, MirrorsHaveOneTexturePerFace) {
    rendered({Rgb(0.4f), Rgb(0.4f)}, false);
    const Result<std::string> text = read_whole_file(folder_.path() / "m_Mirror.inc", 1 << 20);
    ASSERT_TRUE(text);
    EXPECT_NE(text->find("reflection"), std::string::npos);
    EXPECT_NE(text->find("<0,1,2>,0,\n<0,2,3>,0 }"), std::string::npos) << *text;
    EXPECT_NE(text->find("normal_vectors { 4"), std::string::npos);
}

TEST_F(ReflectionTest, SceneFilesKeepReflections) {
    write("box.obj", box_obj);
    const std::string start =
        "[entities.box]\nmesh = \"box.obj\"\nmaterial = \"m\"\n[[instances]]\nentity = \"box\"\n"
        "[environment]\nsky = {}\n[materials.m]\npigment = [1, 0.5, 0]\n";
    const auto read = [&](const std::string& keys) { return read_scene(write("m.toml", start + keys)); };
    struct Case {
        const char* text;
        Reflection expected;
    };
    for (const Case& c : {Case{"", {}}, Case{"reflection = 0.25\n", {Rgb(0.25f), Rgb(0.25f)}},
                          Case{"reflection = { max = [0.5, 1, 0] }\n", {Rgb(0.5f, 1, 0), Rgb(0.5f, 1, 0)}},
                          Case{"reflection = { min = [0, 0, 0.5], max = [1, 1, 1], metallic = 0.5 }\n",
                               {Rgb(0, 0, 0.5f), Rgb(1), 0, 0.5f}},
                          Case{"reflection = { max = [1, 1, 1], ior = 1.5 }\n", {Rgb(0), Rgb(1), 1.5f}}}) {
        const Result<Scene> scene = read(c.text);
        ASSERT_TRUE(scene) << scene.error().message();
        EXPECT_EQ(scene->materials.at("m").reflection, c.expected) << c.text;
        const Result<Scene> again = read_scene(write("again.toml", scene_text(*scene, folder_.path())));
        ASSERT_TRUE(again) << again.error().message();
        EXPECT_EQ(again->materials.at("m").reflection, c.expected) << c.text;
    }
    for (const auto& [keys, message] :
         {std::pair("reflection = 2\n", "materials.m.reflection is 2; expected [0, 1]"),
          {"reflection = { min = [0, 0, 0] }\n", "materials.m.reflection.max is missing"},
          {"reflection = { max = [1, 1, 1], ior = 1 }\n", "materials.m.reflection.ior is 1"},
          {"reflection = { max = [1, 1, 1], shine = 1 }\n", "materials.m.reflection.shine is not known"}}) {
        const Result<Scene> wrong = read(keys);
        ASSERT_FALSE(wrong) << keys;
        EXPECT_NE(wrong.error().message().find(message), std::string::npos) << wrong.error().message();
    }
    const Result<Scene> metal =
        read("reflection = { min = [0.5, 0.5, 0.5], max = [1, 1, 1], metallic = 1 }\n");
    ASSERT_TRUE(metal);
    const Result<SceneEntities> entities = original_entities(*metal);
    ASSERT_TRUE(entities) << entities.error().message();
    EXPECT_EQ(entities->of_instance(0).surfaces.at(0).reflection.at_normal, Rgb(0.5f, 0.25f, 0));
}

}  // namespace
}  // namespace haarfield
