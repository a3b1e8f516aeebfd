/// [[lights]] of scene files, and lights of models.

#include "scenes/lamp_reader.h"

#include <gtest/gtest.h>

#include "fields/model/povray_light.h"
#include "scenes/scene_import.h"
#include "scenes/scene_reader.h"
#include "scenes/scene_writer.h"
#include "tests/fixtures/test_folder.h"

namespace haarfield {
namespace {

constexpr const char* things = R"([entities.bulb]
mesh = "bulb.obj"
[[instances]]
entity = "bulb"
name = "globe"
)";

constexpr const char* lamp_tables = R"([[lights]]
position = [1, 2, 3]
[[lights]]
name = "desk"
kind = "spot"
position = [0, 2, 0]
target = [0, 0, 1]
colour = [3, 2, 1]
fade_distance = 0.5
fade_power = 1
radius = 10
falloff = 20
tightness = 4
area = { across = [1, 0, 0], along = [0, 1, 0], samples = [5, 3], circular = true, orient = true, illumination = true }
looks_like = "globe"
[[lights]]
kind = "cylinder"
position = [0, 2, 0]
target = [0, 0, 0]
radius = 0.2
falloff = 0.3
shadowless = true
[[lights]]
kind = "parallel"
position = [0, 2, 0]
target = [1, 0, 0]
[[keyframes]]
time = 1
light = "desk"
colour = [0, 0, 0]
[[keyframes]]
time = 2
light = "desk"
position = [1, 1, 1]
target = [1, 0, 1]
)";

class LampReader : public testing::Test {
protected:
    LampReader() { write_text(folder / "bulb.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"); }

    Result<Scene> read(const std::string& text) {
        std::filesystem::remove(folder / "room.toml");
        write_text(folder / "room.toml", text);
        return read_scene(folder / "room.toml");
    }

    /// Returns the error of the lamps after one replacement, without the path of the folder.
    std::string message_with(const std::string& from, const std::string& to) {
        std::string text = std::string(things) + lamp_tables;
        const std::size_t at = text.find(from);
        EXPECT_NE(at, std::string::npos) << from;
        text.replace(at, from.size(), to);
        const Result<Scene> scene = read(text);
        return scene ? "accepted" : scene.error().message().substr(folder.path().string().size() + 1);
    }

    const TestFolder folder;
};

TEST_F(LampReader, WhatShedsNoLightIsWrittenSoThatItCanBeRead) {
    Result<Scene> scene = read(std::string(things) + lamp_tables);
    ASSERT_TRUE(scene) << scene.error().message();
    scene->lamps.clear();
    scene->lamp_keyframes.clear();
    const Result<Scene> again = read(scene_text(*scene, folder.path(), ""));
    ASSERT_TRUE(again) << again.error().message();
    EXPECT_TRUE(again->lamps.empty() && again->environment.is_black());
}

TEST_F(LampReader, ReadsEveryKeyInItsUnitAndTheWriterWritesIt) {
    const Result<Scene> first = read(std::string(things) + lamp_tables);
    ASSERT_TRUE(first) << first.error().message();
    EXPECT_TRUE(first->environment.is_black());
    const Result<Scene> again = read(scene_text(*first, folder.path(), ""));
    ASSERT_TRUE(again) << again.error().message();
    EXPECT_TRUE(again->environment.is_black());
    for (const Scene* scene : {&*first, &*again}) {
        const std::vector<SceneLamp>& lamps = scene->lamps;
        ASSERT_EQ(lamps.size(), 4u);
        EXPECT_EQ(lamps[0].name, "light_1");
        EXPECT_EQ(lamps[0].kind, LampKind::point);
        EXPECT_EQ(lamps[0].position, Vec3f(1, 2, 3));
        EXPECT_EQ(lamps[0].colour, Rgb(1, 1, 1));
        EXPECT_EQ(lamps[0].fade_distance, 0);
        EXPECT_FALSE(lamps[0].area || lamps[0].looks_like || lamps[0].shadowless);
        EXPECT_EQ(lamps[1].name, "desk");
        EXPECT_EQ(lamps[1].kind, LampKind::spot);
        EXPECT_EQ(lamps[1].target, Vec3f(0, 0, 1));
        EXPECT_EQ(lamps[1].colour, Rgb(3, 2, 1));
        EXPECT_EQ(lamps[1].fade_distance, 0.5f);
        EXPECT_EQ(lamps[1].fade_power, 1);
        EXPECT_NEAR(lamps[1].radius, pi / 18, 1e-6);
        EXPECT_NEAR(lamps[1].falloff, pi / 9, 1e-6);
        EXPECT_EQ(lamps[1].tightness, 4);
        EXPECT_EQ(lamps[1].looks_like, 0u);
        ASSERT_TRUE(lamps[1].area);
        EXPECT_EQ(lamps[1].area->along, Vec3f(0, 1, 0));
        EXPECT_EQ(lamps[1].area->columns, 5u);
        EXPECT_EQ(lamps[1].area->rows, 3u);
        EXPECT_TRUE(lamps[1].area->circular && lamps[1].area->orient && lamps[1].area->illumination);
        EXPECT_EQ(lamps[2].kind, LampKind::cylinder);
        EXPECT_EQ(lamps[2].radius, 0.2f);
        EXPECT_EQ(lamps[2].falloff, 0.3f);
        EXPECT_TRUE(lamps[2].shadowless);
        EXPECT_EQ(lamps[3].kind, LampKind::parallel);
        EXPECT_EQ(lamps[3].name, "light_4");
    }
    ASSERT_EQ(first->lamp_keyframes.size(), 2u);
    EXPECT_EQ(first->lamp_keyframes[0].lamp, 1u);
    EXPECT_EQ(first->lamp_keyframes[0].colour, Vec3f(0.0f));
    EXPECT_FALSE(first->lamp_keyframes[0].position);
    EXPECT_EQ(first->lamp_keyframes[1].target, Vec3f(1, 0, 1));
    EXPECT_FALSE(read(things)) << "neither lamps nor environment";
}

TEST_F(LampReader, ErrorsNameTheDefect) {
    const auto says = [&](const std::string& from, const std::string& to, const std::string& wanted) {
        EXPECT_NE(message_with(from, to).find(wanted), std::string::npos)
            << to << ": " << message_with(from, to);
    };
    says("position = [1, 2, 3]", "", "lights[0]");
    says("position = [1, 2, 3]", "position = [1, 2, 3]\nglow = 1", "lights[0].glow is not known");
    says("position = [1, 2, 3]", "position = [1, 2, 3]\ntarget = [0, 0, 0]",
         "lights[0].target has no effect in a lamp of kind \"point\"");
    says("position = [1, 2, 3]", "position = [1, 2, 3]\nradius = 3",
         "expected kind \"spot\" or \"cylinder\"");
    says("kind = \"spot\"", "kind = \"bulb\"", "lights[1].kind is \"bulb\"; expected \"point\", \"spot\"");
    says("target = [0, 0, 1]", "target = [0, 2, 0]", "lights[1].target equals the position");
    says("target = [0, 0, 1]\n", "", "target");
    says("colour = [3, 2, 1]", "colour = [3, -2, 1]", "lights[1].colour");
    says("fade_distance = 0.5", "fade_distance = 0", "lights[1].fade_distance is 0");
    says("falloff = 20", "falloff = 5", "lights[1].falloff is less than the radius");
    says("samples = [5, 3]", "samples = [5, 0]", "lights[1].area.samples");
    says("circular = true", "circular = 1", "lights[1].area.circular is 1; expected true or false");
    says("across = [1, 0, 0], ", "", "across");
    says("\"globe\"\n[[lights]]\nkind = \"cyl", "\"lamp\"\n[[lights]]\nkind = \"cyl",
         "there is no such instance");
    says("kind = \"parallel\"", "kind = \"parallel\"\narea = { across = [1, 0, 0], along = [0, 0, 1] }",
         "lights[3].area has no effect in a lamp of kind \"parallel\"");
    says("kind = \"parallel\"", "kind = \"parallel\"\nname = \"desk\"", "which is the name of lights[1]");
    says("light = \"desk\"", "light = \"disk\"", "keyframes[0].light is \"disk\"; there is no such light");
    says("time = 2", "time = 1",
         "keyframes[1].time is 1; expected more than 1, the time of the previous keyframe of desk");
    says("colour = [0, 0, 0]", "", "keyframes[0] has none of position, target and colour");
}

TEST(PovrayLight, IsReadAsPlainData) {
    const auto read = [](const char* text) { return povray_light(PovrayText(text)); };
    const auto point = read("{ <1, 2, 3> color rgb <0.5, 1, 2> fade_distance 2 fade_power 1.5 }");
    ASSERT_TRUE(point);
    EXPECT_EQ(point->kind, ModelLight::Kind::point);
    EXPECT_EQ(point->position, Vec3f(1, 2, 3));
    EXPECT_EQ(point->colour, Rgb(0.5f, 1, 2));
    EXPECT_EQ(point->fade_distance, 2);
    EXPECT_EQ(point->fade_power, 1.5f);
    const auto spot = read(
        "{ 0*x, White spotlight point_at <0, -1, 0> falloff 20 tightness 3 shadowless "
        "looks_like { sphere { 0, 1 } } translate 2*y }");
    ASSERT_TRUE(spot);
    EXPECT_EQ(spot->kind, ModelLight::Kind::spot);
    EXPECT_EQ(spot->position, Vec3f(0, 2, 0));
    EXPECT_EQ(spot->target, Vec3f(0, 1, 0));
    EXPECT_EQ(spot->colour, Rgb(1.0f));
    EXPECT_NEAR(spot->falloff, pi / 9, 1e-6);
    EXPECT_NEAR(spot->radius, pi / 9, 1e-6) << "POV-Ray's own is larger";
    EXPECT_TRUE(spot->shadowless);
    const auto area = read("{ y rgb 2 area_light x, 0.5*z, 4, 5 adaptive 1 jitter circular orient }");
    const auto plain = read("{ y rgb 2 spotlight }");
    ASSERT_TRUE(plain);
    EXPECT_NEAR(plain->radius, pi / 6, 1e-6);
    EXPECT_NEAR(plain->falloff, pi / 4, 1e-6);
    EXPECT_EQ(plain->target, Vec3f(0, 0, 1));
    ASSERT_TRUE(area && area->area);
    EXPECT_EQ(area->area->along, Vec3f(0, 0, 0.5f));
    EXPECT_EQ(area->area->columns, 4u);
    EXPECT_TRUE(area->area->circular && area->area->orient && !area->area->illumination);
    const auto sun = read("{ <6e8, 8e8, 0> rgb 1 }");
    ASSERT_TRUE(sun) << "as in POV-Ray's sunpos.inc";
    EXPECT_LE(sun->position.length(), 1e6f);
    EXPECT_GT(sun->position.length(), 0.99e6f);
    EXPECT_LT((sun->position.normalized() - Vec3f(0.6f, 0.8f, 0)).length(), 1e-6f);
    EXPECT_FALSE(read("{ <6e8, 8e8, 0> rgb 1 fade_distance 3 fade_power 2 }"));
    for (const char* text :
         {"{ y rgb Lamp_Colour }", "{ Place rgb 1 }", "{ y }", "{ y rgb 1 + 2 }", "{ y rgb <1, 2> }",
          "{ y rgb 1", "", "{ y rgb -1 }", "{ y rgb 1 projected_through { Window } }"})
        EXPECT_FALSE(read(text)) << text;
}

TEST_F(LampReader, LightsOfModelsBecomeLamps) {
    const auto import = [&](const char* name, const std::string& text, const SceneImport& wanted = {}) {
        write_text(folder / name, text);
        const std::filesystem::path file = folder / name;
        Result<ImportedScene> imported = scene_of_models({&file, 1}, folder.path(), wanted);
        EXPECT_TRUE(imported) << imported.error().message();
        return imported ? std::move(*imported) : ImportedScene{};
    };
    const std::string mesh =
        "mesh2 { vertex_vectors { 3, <0,0,0>, <1,0,0>, <0,1,0> } face_indices { 1, <0,1,2> } }\n";
    const ImportedScene pov =
        import("lit.pov",
               mesh +
                   "light_source { <0, 3, 0> rgb <2, 1, 1> fade_distance 2 fade_power 2 }\n"
                   "light_source { Somewhere rgb 1 }\n#if (Night) light_source { y rgb 1 } #end\n",
               {.unit = 0.5});
    ASSERT_EQ(pov.scene.lamps.size(), 1u);
    EXPECT_TRUE(pov.scene.environment.is_black());
    EXPECT_EQ(pov.scene.lamps[0].position, Vec3f(0, 1.5f, 0));
    EXPECT_EQ(pov.scene.lamps[0].fade_distance, 1);
    EXPECT_EQ(pov.scene.lamps[0].colour, Rgb(2, 1, 1));
    ASSERT_EQ(pov.warnings.size(), 1u);
    EXPECT_NE(pov.warnings[0].find("2 light_sources are not plain data"), std::string::npos);

    const std::string gltf =
        R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1,2]}],"extensionsUsed":["KHR_lights_punctual"],
"extensions":{"KHR_lights_punctual":{"lights":[
{"type":"spot","color":[1,0.5,0.25],"intensity":683,"spot":{"innerConeAngle":0.2,"outerConeAngle":0.5}},
{"type":"directional","intensity":683}]}},
"nodes":[{"name":"leaf","mesh":0},
{"name":"beam","translation":[0,4,0],"rotation":[-0.7071067811865476,0,0,0.7071067811865476],"extensions":{"KHR_lights_punctual":{"light":0}}},
{"name":"sun","extensions":{"KHR_lights_punctual":{"light":1}}}],
"meshes":[{"name":"leaf","primitives":[{"attributes":{"POSITION":0}}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":36}],
"buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})";
    for (const double unit : {1.0, 3.0}) {
        const Scene scene = import("lit.gltf", gltf, {.unit = unit}).scene;
        EXPECT_TRUE(scene.environment.sky) << "the lights of a model need not be all that lights it";
        EXPECT_FALSE(scene.environment.exposure);
        ASSERT_EQ(scene.lamps.size(), 2u);
        const SceneLamp &beam = scene.lamps[0], &sun = scene.lamps[1];
        EXPECT_EQ(beam.name, "beam");
        EXPECT_EQ(beam.kind, LampKind::spot);
        EXPECT_NEAR(beam.radius, 0.2, 1e-5);
        EXPECT_NEAR(beam.falloff, 0.5, 1e-5);
        EXPECT_NEAR((beam.target - beam.position).normalized().y, -1, 1e-5);
        // An intensity of 1 W/sr in red gives 1 / 2^2 W/m^2 two units below, in the file's own scale.
        const LampLight below = lamp_light(beam, Vec3d(0, 2 * unit, 0));
        EXPECT_NEAR(pi * below.share * double(beam.colour.x), 0.25, 1e-4);
        EXPECT_NEAR(pi * below.share * double(beam.colour.z), 0.0625, 1e-4);
        EXPECT_EQ(sun.kind, LampKind::parallel);
        const LampLight daylight = lamp_light(sun, Vec3d(0.5, 0.5, 0));
        EXPECT_NEAR(pi * daylight.share * double(sun.colour.y), 1, 1e-5);
        EXPECT_NEAR(daylight.direction.z, 1, 1e-6);
        EXPECT_GT(daylight.distance, unit);
    }
    EXPECT_TRUE(import("lit.gltf", gltf, {.no_environment = true}).scene.environment.is_black());

    std::string bright = gltf;
    bright.replace(bright.find("\"intensity\":683}"), 16, "\"intensity\":100000}");
    const ImportedScene noon = import("noon.gltf", bright);
    ASSERT_EQ(noon.scene.lamps.size(), 2u);
    EXPECT_NEAR(double(noon.scene.lamps[1].colour.y), 1.25, 0.01) << "a white sphere (0.8) shines with 1";
    ASSERT_EQ(noon.warnings.size(), 1u);
    EXPECT_NE(noon.warnings[0].find("are scaled by"), std::string::npos);
}

}  // namespace
}  // namespace haarfield
