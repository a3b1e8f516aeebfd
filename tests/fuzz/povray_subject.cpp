#include "tests/fuzz/povray_subject.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "bridge/povray_import/imported_scene.h"
#include "scenes/scene_reader.h"
#include "scenes/scene_writer.h"
#include "tests/fixtures/example_textures.h"
#include "tests/fixtures/test_folder.h"
#include "tests/fuzz/import_room.h"
#include "tests/fuzz/structured_changes.h"

namespace haarfield {
namespace {

using std::filesystem::path;

/// Scenes of different styles. They include `part.inc` and read `wood.png`, both in their folder.
const std::vector<std::string>& example_povray_scenes() {
    static const std::vector<std::string> scenes{
        R"(#version 3.7;
global_settings { assumed_gamma 1.0 }
camera { location <0, 2, -6> look_at <0, 0.5, 0> angle 40 }
light_source { <5, 8, -6> rgb 1 }
background { rgb <0.2, 0.3, 0.5> }
plane { y, 0 pigment { checker rgb 0.2 rgb 0.8 } }
sphere { <0, 1, 0>, 1 pigment { rgb <0.8, 0.2, 0.1> } finish { phong 0.5 phong_size 60 diffuse 0.7 } }
)",
        R"(#version 3.7;
#include "colors.inc"
#include "part.inc"
camera { perspective location <3, 3, -5> right x*image_width/image_height look_at 0 }
light_source { <2, 6, -4> color White spotlight point_at 0 radius 20 falloff 30 }
#declare Count = 3;
#local I = 0;
#while (I < Count)
  object { Part(I) translate <I - 1, 0, 0> }
  #local I = I + 1;
#end
difference { box { -1, <1, 0.5, 1> } cylinder { -2*y, 2*y, 0.4 } texture { pigment { Red } } }
)",
        R"(#version 3.6;
#macro Row(N, What)
  #for (K, 1, N)
    object { What translate <K * 0.6 - 1.5, 0.3, 0> rotate y * K * 10 }
  #end
#end
camera { location <0, 1, -4> look_at <0, 0.3, 0> }
light_source { <-3, 5, -3>, 1.2 area_light x, z, 2, 2 }
sky_sphere { pigment { gradient y color_map { [0 rgb 1] [1 rgb <0.2, 0.4, 1>] } } }
Row(4, superellipsoid { <0.4, 0.6> scale 0.25 pigment { wood color_map { [0 rgb 0.6] [1 rgb 0.2] } } })
torus { 0.6, 0.1 translate y pigment { image_map { png "wood.png" } } }
)",
        R"(#version 3.7;
global_settings { max_trace_level 4 }
#default { finish { ambient 0.1 diffuse 0.8 } }
#declare F = function(x, y, z) { x*x + y*y + z*z - 1 + 0.1*sin(8*x) };
camera { location <0, 0, -4> look_at 0 }
light_source { <4, 4, -4> rgb <1, 0.9, 0.8> fade_distance 5 fade_power 2 }
isosurface { function { F(x, y, z) } contained_by { box { -1.3, 1.3 } } max_gradient 6 pigment { rgb 0.7 } }
fog { distance 40 rgb 0.5 }
)",
        R"(#version 3.7;
camera { location <0, 3, -5> look_at 0 sky y up y right x }
light_source { <0, 5, -2> rgb 1 parallel point_at 0 }
#declare Where = array[3] { <0, 0, 0>, <1, 0, 0>, <-1, 0, 0.5> };
#declare Line = spline { linear_spline 0, <0, 0, 0> 1, <0, 1, 0> };
merge { sphere { Where[0], 0.5 } sphere { Where[1], 0.4 } translate Line(0.5) pigment { rgbt <1, 1, 1, 0.8> } }
lathe { linear_spline 4, <0, 0>, <0.4, 0>, <0.3, 0.6>, <0, 0.6> translate Where[2] pigment { rgb <0, 1, 0> } }
text { ttf "timrom.ttf" "Hf" 0.2, 0 pigment { marble } }
#if (clock > 0) sphere { 0, 2 } #else box { -0.1, 0.1 no_shadow } #end
)",
        R"(#version 3.7;
camera { location <2, 2, -3> look_at 0 angle 50 }
light_source { <3, 5, -3> rgb 1 }
mesh2 { vertex_vectors { 4 <0,0,0> <1,0,0> <0,1,0> <0,0,1> } uv_vectors { 3 <0,0> <1,0> <0,1> }
  face_indices { 4 <0,2,1> <0,1,3> <1,2,3> <2,0,3> } uv_indices { 4 <0,1,2> <0,1,2> <1,2,0> <2,0,1> }
  uv_mapping pigment { image_map { png "wood.png" interpolate 2 } } }
height_field { png "wood.png" smooth scale <1, 0.3, 1> translate <-1.5, 0, 0> pigment { rgb 0.5 } }
blob { threshold 0.6 sphere { 0, 0.8, 1 } cylinder { 0, x, 0.4, 1 } pigment { bozo } normal { bumps 0.4 } }
prism { linear_sweep linear_spline 0, 0.4, 4, <0,0>, <1,0>, <0,1>, <0,0> finish { reflection 0.3 } }
)"};
    return scenes;
}

/// An included file that declares a macro.
constexpr std::string_view part_inc = R"(#macro Part(N)
  union {
    cone { 0, 0.3, y * 0.8, 0.1 }
    sphere { y * 0.9, 0.15 }
    pigment { rgb <0.2 * N, 0.5, 0.5> }
  }
#end
)";

/// Statements that harm an import that is not careful. @OUT@ is a folder that the scene must not use.
constexpr std::array<std::string_view, 34> hostile_statements{
    "#while (1) #end",
    "#declare I = 0; #while (I < 1000000000) #declare I = I + 1; #end",
    "#macro Again() Again() #end Again()",
    "#declare Big = array[1000000][1000];",
    "#fopen F \"@OUT@/written.txt\" write #write (F, \"x\") #fclose F",
    "#fopen F \"../outside/written.txt\" append #write (F, 1) #fclose F",
    "#fopen F \"@OUT@/part.inc\" read #read (F, Read) #fclose F",
    "#include \"../outside/part.inc\"",
    "#include concat(\"@OUT@\", \"/part.inc\")",
    "#include \"@OUT@/part.inc\"",
    "#include \"scene.pov\"",
    "sphere { 0, 1 pigment { image_map { png \"../outside/wood.png\" } } }",
    "height_field { png \"@OUT@/wood.png\" }",
    "text { ttf \"@OUT@/none.ttf\" \"a\" 1, 0 }",
    "#if (file_exists(\"@OUT@/part.inc\")) #error \"found\" #end",
    "#declare HF_N = 1000000;",
    "#declare HF_A = array[2];",
    "#undef HF_A",
    "#macro HF_Put(I) #end",
    "#declare HF_E = -1;",
    "#debug \"HF_OBJECT 99999999999999\\n\"",
    "#error \"stop\"",
    "#warning concat(\"\\u0000\", str(1e308, 300, 300))",
    "sphere { <1e30, 0, 0>, 1e38 }",
    "sphere { 0, 1e-30 }",
    "box { <0/0, 0, 0>, 1 }",
    "triangle { 0, 0, 0 }",
    "camera { orthographic location 0 look_at 0 }",
    "camera { location <0, 0, 0> direction 0 right 0 up 0 }",
    "julia_fractal { <-0.1, 0.8, 0.2, 0> quaternion max_iteration 1000000 precision 1000000 }",
    "isosurface { function { sin(1000*x)*sin(1000*y) } max_gradient 1e9 accuracy 1e-12 all_intersections }",
    "#local Deep = \"sphere\" #for (I, 0, 100000) sphere { I, 0.1 } #end",
    "light_source { 0 rgb 1e38 }",
    "} #end #end",
};

const std::vector<std::string_view>& povray_words() {
    static const std::vector<std::string_view> words{"#declare ",
                                                     "#local ",
                                                     "#macro M() ",
                                                     "#end ",
                                                     "#while (1) ",
                                                     "#if (0) ",
                                                     "#else ",
                                                     "#switch (1) ",
                                                     "#case (1) ",
                                                     "#break ",
                                                     "#include ",
                                                     "#undef ",
                                                     "#version ",
                                                     "#default ",
                                                     "union {",
                                                     "difference {",
                                                     "intersection {",
                                                     "object {",
                                                     "clipped_by",
                                                     "bounded_by {",
                                                     "no_shadow ",
                                                     "hollow ",
                                                     "inverse ",
                                                     "texture {",
                                                     "pigment {",
                                                     "finish {",
                                                     "normal {",
                                                     "interior {",
                                                     "media {",
                                                     "material {",
                                                     "scale ",
                                                     "rotate ",
                                                     "translate ",
                                                     "matrix <",
                                                     "camera {",
                                                     "light_source {",
                                                     "sphere {",
                                                     "plane {",
                                                     "polygon {",
                                                     "sphere_sweep {",
                                                     "parametric {",
                                                     "photons {",
                                                     "radiosity {",
                                                     "rainbow {",
                                                     "/*",
                                                     "*/",
                                                     "//",
                                                     "\"",
                                                     "{",
                                                     "}",
                                                     "<",
                                                     ">",
                                                     "(",
                                                     ")",
                                                     "1e38",
                                                     "-1e-38",
                                                     "0",
                                                     "65536",
                                                     "clock",
                                                     "rand(seed(1))"};
    return words;
}

/// The place of the folder that scenes must not use.
constexpr std::string_view out_mark = "@OUT@";

void add_hostile_statement(std::string& text, FuzzRandom& random) {
    const std::size_t line = text.find('\n', random_index(random, text.size()));
    text.insert(line == std::string::npos ? text.size() : line + 1,
                std::string(hostile_statements[random_index(random, hostile_statements.size())]) + "\n");
}

class DamagedPovrayScenes : public Subject {
public:
    std::string file_name() const override { return "scene.pov"; }
    unsigned seconds() const override { return 60; }
    unsigned clock_seconds() const override { return 600; }
    std::string input(FuzzRandom& random) override {
        const std::vector<std::string>& scenes = example_povray_scenes();
        std::string text = scenes[random_index(random, scenes.size())];
        switch (random_index(random, 4)) {
            case 0: add_hostile_statement(text, random); break;
            case 1: add_hostile_statement(text, random); [[fallthrough]];
            case 2: change_structure(text, random, FileKind::text); break;
            default: damage(text, random, scenes[random_index(random, scenes.size())], povray_words());
        }
        return text;
    }
    std::string objection(const path& file, Outcome& outcome) override {
        const ImportRoom room(file.parent_path() / "room");
        std::string text = text_of(file);
        for (std::size_t at = 0; (at = text.find(out_mark, at)) != std::string::npos;)
            text.replace(at, out_mark.size(), room.outside().string());
        for (const path& to : {room.models(), room.outside()}) {
            write_text(to / "part.inc", std::string(part_inc));
            write_text(to / "wood.png", *png_bytes(random_texture(5, 4).texels, 5, 4, false));
        }
        write_text(room.models() / "scene.pov", text);
        return room.objection([&] { return imported(room.models() / "scene.pov", room.output(), outcome); });
    }

private:
    static std::string imported(const path& file, const path& output, Outcome& outcome) {
        PovrayImport options;
        options.queries.threads = 1;
        options.queries.seconds = 10;
        options.queries.memory = std::uint64_t{1} << 30;
        options.detail = 8;
        options.object_seconds = 0.5;
        options.vertices = 1000;
        const Result<ImportedPovrayScene> made =
            imported_povray_scene(file, output, "scene", options, Progress{});
        if (!made) {
            if (made.error().what.empty() || made.error().where.empty())
                return "refused without a reason or a place";
            (void)outcome.refused(made.error());
            return {};
        }
        outcome.accepted = true;
        write_text(output / "scene.toml", scene_text(made->scene, output));
        const Result<Scene> read = read_scene(output / "scene.toml");
        return read ? "" : "imported to a scene that cannot be read: " + read.error().message();
    }
};

}  // namespace

std::unique_ptr<Subject> damaged_povray_scenes() {
    return std::make_unique<DamagedPovrayScenes>();
}

}  // namespace haarfield
