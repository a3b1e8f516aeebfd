#include "bridge/povray_import/scene_queries.h"
#include "bridge/povray_import/scene_survey.h"
#include "bridge/povray_import/scene_tokens.h"
#include "bridge/povray_import/wrapped_scene.h"
#include "fields/file/write_file.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

namespace haarfield {
namespace {

std::filesystem::path fresh_folder(const std::string& name) {
    const std::filesystem::path folder = std::filesystem::temp_directory_path() / ("haarfield_" + name);
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    return folder;
}

std::filesystem::path written_scene(const std::string& name, const std::string& text) {
    const std::filesystem::path file = fresh_folder(name) / "scene.pov";
    EXPECT_TRUE(write_file(file, text));
    return file;
}

std::string joined(std::string_view text) {
    const Result<std::vector<SceneToken>> tokens = scene_tokens(text);
    if (!tokens) return tokens.error().what;
    std::string line;
    for (const SceneToken& token : *tokens)
        line += fmt::format("{}{}|", token.kind == SceneToken::Kind::directive ? "#" : "", token.text);
    return line;
}

TEST(SceneTokens, AreWordsNumbersStringsSymbolsAndDirectives) {
    EXPECT_EQ(joined("# declare A_1=.5e-3*x; // c\n\"a\\\"b\" /* a /* b */ c */ {<1,-2.>} a!=b<=c"),
              "#declare|A_1|=|.5e-3|*|x|;|a\\\"b|{|<|1|,|-|2.|>|}|a|!=|b|<=|c|");
    EXPECT_EQ(joined(""), "");
    EXPECT_EQ(joined("1.2.x 3e4e"), "1.2|.|x|3e4|e|");
}

TEST(SceneTokens, UnterminatedCommentsAndStringsAreErrorsWithTheirLine) {
    EXPECT_EQ(joined("a\n\"b"), "line 2: found the end of the file in a string; expected \"");
    EXPECT_EQ(joined("a\n\nb /* /* */"), "line 3: found the end of the file in a comment; expected */");
    EXPECT_EQ(joined("\"a\\"), "line 1: found the end of the file in a string; expected \"");
}

/// Returns the text of the expression at the beginning.
std::string expression(std::string_view text) {
    const Result<std::vector<SceneToken>> tokens = scene_tokens(text);
    const std::size_t end = end_of_expression(*tokens, 0);
    return end == 0 ? "" : std::string(text.substr(0, (*tokens)[end - 1].end));
}

TEST(SceneTokens, ExpressionsEndBeforeTheNextStatement) {
    EXPECT_EQ(expression("3 sphere{0,1}"), "3");
    EXPECT_EQ(expression("-a.x*(b+1)/c[2] box{}"), "-a.x*(b+1)/c[2]");
    EXPECT_EQ(expression("<1,-2,3>*vlength(x) rgb 1"), "<1,-2,3>*vlength(x)");
    EXPECT_EQ(expression("color red 1 green .5 finish{}"), "color red 1 green .5");
    EXPECT_EQ(expression("color rgb <1,2,3>*2 point_at 0"), "color rgb <1,2,3>*2");
    EXPECT_EQ(expression("texture{a} texture{b{c}} sphere{}"), "texture{a} texture{b{c}}");
    EXPECT_EQ(expression("function(u,v){u*v} M(1)"), "function(u,v){u*v}");
    EXPECT_EQ(expression("array[2][2]{{1,2},{3,4}} x"), "array[2][2]{{1,2},{3,4}}");
    EXPECT_EQ(expression("#if(a) box{} #else sphere{} #end torus{}"), "#if(a) box{} #else sphere{} #end");
    EXPECT_EQ(expression("{a}"), "");
    EXPECT_EQ(expression(""), "");
}

TEST(SceneTokens, BranchesOfConditionsNeedNotBalanceTheirBraces) {
    const auto tokens = scene_tokens("{ #if(a) union{ #else difference{ #end b } } c");
    EXPECT_EQ((*tokens)[end_of_group(*tokens, 0)].text, "c");
    const auto open = scene_tokens("{ a #else } #end");
    EXPECT_EQ(end_of_group(*open, 0), 0u);
    EXPECT_EQ(end_of_group(*scene_tokens("{ (a"), 0), 0u);
}

WrappedScene wrapped(const std::string& text) {
    const Result<WrappedScene> scene = wrapped_scene(written_scene("wrapping", text));
    EXPECT_TRUE(scene) << scene.error().message();
    return *scene;
}

std::size_t count(const std::string& text, const std::string& part) {
    std::size_t number = 0;
    for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; ++at) ++number;
    return number;
}

TEST(WrappedScene, TopLevelObjectsBecomeElementsOfAnArray) {
    const WrappedScene scene = wrapped(
        "#version 3.7;\n#declare S=sphere{0,1}\nobject{S}\n#while(0)\nbox{0,1 texture{finish{phong "
        "1}}}\n#end\n"
        "union{sphere{0,1} box{0,1}}\ncamera{location x}\n");
    ASSERT_EQ(scene.statements.size(), 3u);
    EXPECT_EQ(scene.statements[0].keyword, "object");
    EXPECT_EQ(scene.statements[0].name, "S");
    EXPECT_EQ(scene.statements[0].line, 3u);
    EXPECT_EQ(scene.statements[1].keyword, "box");
    EXPECT_EQ(scene.statements[1].line, 5u);
    EXPECT_EQ(scene.statements[2].keyword, "union");
    const std::string& text = scene.files[0].text;
    EXPECT_EQ(count(text, "#declare HF_A[HF_N]="), 3u);
    EXPECT_TRUE(text.starts_with("#version 3.7;"));
    EXPECT_EQ(count(text, "phong"), 1u);
    EXPECT_EQ(count(scene.files[0].emissive_text, "phong"), 0u);
    EXPECT_EQ(count(scene.files[0].emissive_text, "emission HF_E"), 1u);
    EXPECT_TRUE(scene.declared.contains("S"));
}

TEST(WrappedScene, FollowsIncludesWithLiteralNames) {
    const std::filesystem::path file = written_scene(
        "includes", "#include \"part.inc\"\n#include concat(\"a\",\"b\")\n#include \"missing.inc\"\n");
    ASSERT_TRUE(write_file(file.parent_path() / "part.inc", "box{0,1}\n#include \"part.inc\"\n"));
    const Result<WrappedScene> scene = wrapped_scene(file);
    ASSERT_TRUE(scene) << scene.error().message();
    ASSERT_EQ(scene->files.size(), 2u);
    EXPECT_EQ(scene->statements.size(), 1u);
    EXPECT_EQ(scene->statements[0].file, "part.inc");
    EXPECT_NE(scene->files[0].text.find("#include \"hf_include_1.inc\""), std::string::npos);
    EXPECT_NE(scene->files[0].text.find("missing.inc"), std::string::npos);
}

TEST(WrappedScene, ReadsNoIncludesOutsideTheFolderOfTheScene) {
    const std::filesystem::path file = written_scene("outside", "");
    const std::filesystem::path folder = file.parent_path() / "scenes", scene = folder / "scene.pov";
    std::filesystem::create_directories(folder);
    ASSERT_TRUE(write_file(file.parent_path() / "other.inc", "sphere{0,1}"));
    ASSERT_TRUE(write_file(folder / "near.inc", "sphere{0,1}"));
    std::filesystem::create_symlink(file.parent_path() / "other.inc", folder / "link.inc");
    ASSERT_TRUE(
        write_file(scene, fmt::format("#include \"../other.inc\"\n#include \"{}\"\n#include \"link.inc\"\n"
                                      "#include \"near.inc\"\n",
                                      (file.parent_path() / "other.inc").string())));
    const Result<WrappedScene> wrapped = wrapped_scene(scene);
    ASSERT_TRUE(wrapped) << wrapped.error().message();
    EXPECT_EQ(wrapped->files.size(), 2u);
    EXPECT_EQ(wrapped->statements.size(), 1u);
}

TEST(WrappedScene, NamesWhatIsLeftOutWithItsLine) {
    const WrappedScene scene = wrapped("sphere{0,1\ninterior{media{}}\nfinish{subsurface{1}}}\n");
    ASSERT_EQ(scene.unused.size(), 3u);
    EXPECT_EQ(scene.unused[1].keyword, "media");
    EXPECT_EQ(scene.unused[1].line, 2u);
}

TEST(WrappedScene, BadFilesAreErrors) {
    EXPECT_FALSE(wrapped_scene("/nowhere/scene.pov"));
    const Result<WrappedScene> scene = wrapped_scene(written_scene("bad", "sphere{0,1}\n\n/* "));
    ASSERT_FALSE(scene);
    EXPECT_NE(scene.error().message().find("scene.pov: line 3: "), std::string::npos)
        << scene.error().message();
}

SceneSurvey surveyed(const std::string& text) {
    const Result<SceneQueries> queries = SceneQueries::create(written_scene("survey", text), {});
    EXPECT_TRUE(queries) << queries.error().message();
    const Result<SceneSurvey> survey = scene_survey(*queries);
    EXPECT_TRUE(survey) << survey.error().message();
    return survey ? *survey : SceneSurvey();
}

TEST(SceneSurvey, FindsObjectsOfLoopsMacrosAndConditions) {
    const SceneSurvey survey = surveyed(
        "#version 3.7;\nglobal_settings{assumed_gamma 1}\n"
        "#macro Two(P) sphere{P,1} sphere{P+5*x,1} #end\n#macro View() camera{location <1,2,-3> look_at 0} "
        "#end\n"
        "#for(I,1,3) box{I,I+.5} #end\nTwo(<0,9,0>)\nView()\n#if(0) torus{1,.1} #end\nplane{y,0}\n");
    ASSERT_EQ(survey.objects.size(), 7u);  // The two macros that end with a camera leave an empty union each.
    EXPECT_EQ(survey.objects[1].lower, Vec3d(2, 2, 2));
    EXPECT_EQ(survey.objects[3].upper, Vec3d(6, 10, 1));
    EXPECT_TRUE(survey.objects[6].is_infinite());
    ASSERT_TRUE(survey.camera);
    EXPECT_LT((survey.camera->position - Vec3d(1, 2, -3)).length(), 1e-6);
}

TEST(SceneSurvey, CameraHasPositionAxesAndHandedness) {
    const SceneSurvey survey = surveyed(
        "#version 3.7;\nglobal_settings{assumed_gamma 2.2}\n"
        "#declare C=camera{location <0,0,-5> right -x*4/3 angle 60 look_at 0}\n"
        "camera{C rotate 30*y translate <100,0.5,0>}\nsphere{0,1}\n");
    ASSERT_TRUE(survey.camera);
    const SurveyedCamera& camera = *survey.camera;
    EXPECT_TRUE(camera.is_perspective);
    EXPECT_FALSE(camera.is_left_handed());
    EXPECT_LT((camera.position - Vec3d(100 - 2.5, 0.5, -5 * std::cos(pi / 6))).length(), 1e-4);
    EXPECT_NEAR(camera.right.length() / camera.direction.length(), 2 * std::tan(pi / 6), 1e-4);
    EXPECT_NEAR(camera.up.length() / camera.right.length(), 0.75, 1e-4);
}

TEST(SceneSurvey, OtherProjectionsAreNotPerspective) {
    const SceneSurvey survey =
        surveyed("#version 3.7;\ncamera{fisheye angle 150 location <0,1,-5> look_at 0}\nsphere{0,1}\n");
    ASSERT_TRUE(survey.camera);
    EXPECT_FALSE(survey.camera->is_perspective);
}

TEST(SceneSurvey, ADistantCameraStandsForAnOrthographicOne) {
    const std::string start =
        "#version 3.7;\nglobal_settings{assumed_gamma 1}\n"
        "#declare C=camera{location <9,2,3> look_at 0}\n"
        "camera{orthographic location <3,2,-10> look_at <3,2,0> right 4*x up 3*y}\n";
    const SceneSurvey survey = surveyed(start + "sphere{<3,2,5>,1}\n");
    ASSERT_TRUE(survey.camera);
    const SurveyedCamera& camera = *survey.camera;
    EXPECT_TRUE(camera.is_perspective);
    EXPECT_LT((camera.start() - Vec3d(3, 2, -10)).length(), 1e-2);
    // At the sphere's distance, the picture shows as much as through parallel rays.
    const double share = (Vec3d(3, 2, 5) - camera.position).length() / camera.direction.length();
    EXPECT_LT((camera.right * share - Vec3d(4, 0, 0)).length(), 1e-3);
    EXPECT_LT((camera.up * share - Vec3d(0, 3, 0)).length(), 1e-3);
    EXPECT_GT(camera.direction.length(), 900 * camera.right.length());
    // A room leaves no place for such a camera.
    EXPECT_FALSE(surveyed(start + "box{-20,20}\n").camera->is_perspective);
}

TEST(SceneSurvey, EvaluatesLights) {
    const SceneSurvey survey = surveyed(
        "#version 3.7;\n#declare H=7;\n#declare L=light_source{<0,H,0> rgb 2*<1,.5,.25> spotlight point_at x "
        "radius 2*10 falloff 30}\n"
        "light_source{L translate 2*y}\n#if(1) light_source{<1,2,3>*2, color rgb 1 area_light x,z*2,4,3 "
        "circular fade_distance 3 fade_power 2 looks_like{sphere{0,1}}} #end\n#if(0) light_source{0,1} "
        "#end\n");
    ASSERT_EQ(survey.lights.size(), 2u);
    EXPECT_EQ(survey.unread_lights.size(), 0u);
    EXPECT_EQ(survey.lights[0].position, Vec3f(0, 9, 0));
    EXPECT_EQ(survey.lights[0].target, Vec3f(1, 2, 0));
    EXPECT_EQ(survey.lights[0].colour, Rgb(2, 1, 0.5f));
    EXPECT_NEAR(survey.lights[0].radius, 20 * pi / 180, 1e-6);
    EXPECT_EQ(survey.lights[1].position, Vec3f(2, 4, 6));
    ASSERT_TRUE(survey.lights[1].area);
    EXPECT_EQ(survey.lights[1].area->columns, 4u);
    EXPECT_TRUE(survey.lights[1].area->circular);
    EXPECT_EQ(survey.lights[1].fade_distance, 3);
}

TEST(SceneQueries, SandboxedScenesWriteNothingElsewhereAndReadNoOtherFolder) {
    const std::filesystem::path other = fresh_folder("other_folder"), target = other / "written.txt";
    ASSERT_TRUE(write_file(other / "secret.inc", "#declare Secret=1;"));
    for (const std::string& statement :
         {fmt::format("#fopen F \"{}\" write\n#write(F,\"1\")\n#fclose F\n", target.string()),
          fmt::format("#include concat(\"{}\",\"\")\n", (other / "secret.inc").string()),
          fmt::format("#include \"{}\"\n", (other / "secret.inc").string())}) {
        const Result<SceneQueries> queries =
            SceneQueries::create(written_scene("sandboxed", "#version 3.7;\n" + statement), {});
        ASSERT_TRUE(queries) << queries.error().message();
        const Result<SceneAnswer> answer = queries->answer({});
        EXPECT_FALSE(answer) << statement;
        EXPECT_FALSE(std::filesystem::exists(target));
    }
}

TEST(SceneQueries, ScenesMayWriteFilesInTheScratchFolder) {
    const Result<SceneQueries> queries = SceneQueries::create(
        written_scene("writes", "#version 3.7;\n#fopen F \"a.txt\" write\n#write(F,\"1\")\n#fclose F\n"), {});
    ASSERT_TRUE(queries) << queries.error().message();
    const Result<SceneAnswer> answer = queries->answer({});
    ASSERT_TRUE(answer) << answer.error().message();
    EXPECT_TRUE(std::filesystem::exists(queries->scratch() / "a.txt"));
}

TEST(SceneQueries, EndlessScenesAreEnded) {
    QueryOptions options;
    options.seconds = 1.5;
    const Result<SceneQueries> queries =
        SceneQueries::create(written_scene("endless", "#version 3.7;\n#while(1) #end\n"), options);
    ASSERT_TRUE(queries) << queries.error().message();
    const Result<SceneAnswer> answer = queries->answer({});
    ASSERT_FALSE(answer);
    EXPECT_NE(answer.error().what.find("took longer than 1.5 s"), std::string::npos) << answer.error().what;
}

TEST(SceneQueries, ErrorsOfTheSceneAreReported) {
    const Result<SceneQueries> queries =
        SceneQueries::create(written_scene("faulty", "#version 3.7;\nsphere{0,1\n texture{Missing}}\n"), {});
    ASSERT_TRUE(queries) << queries.error().message();
    const Result<SceneAnswer> answer = queries->answer({});
    ASSERT_FALSE(answer);
    EXPECT_NE(answer.error().what.find("Parse Error"), std::string::npos) << answer.error().what;
}

}  // namespace
}  // namespace haarfield
