#include "fields/model/mesh2_file.h"

#include "fields/model/mesh_reader.h"
#include "tests/fixtures/test_folder.h"
#include "tests/fuzz/fuzz_inputs.h"

#include <gtest/gtest.h>

#include <cmath>

namespace haarfield {
namespace {

using Indices = std::array<std::uint32_t, 3>;

const std::string corners = "vertex_vectors { 3, <0,0,0>, <1,0,0>, <0,1,0> }";
const std::string triangle = corners + " face_indices { 1, <0,1,2> }";

Mesh2File file_of(const std::string& text) {
    Result<Mesh2File> file = read_mesh2(text);
    EXPECT_TRUE(file) << text << ": " << file.error().message();
    return file ? *std::move(file) : Mesh2File{};
}

Mesh2 mesh_of(const std::string& items) {
    const Mesh2File file = file_of("mesh2 { " + items + " }");
    EXPECT_EQ(file.meshes.size(), 1u) << items;
    return file.meshes.empty() ? Mesh2{} : file.meshes[0];
}

std::string message_of(const std::string& text) {
    const Result<Mesh2File> file = read_mesh2(text);
    return file ? "accepted" : file.error().what;
}

TEST(Mesh2File, AllListsOfAMeshAreRead) {
    const Mesh2 mesh = mesh_of(
        "vertex_vectors { 4, <0,0,0>, <1,0,0>, <0,1,0>, <0,0,1>, }\n"
        "normal_vectors { 2 <0,0,1> <0,-2,0> }\n"
        "uv_vectors { 2, <0.5,-.5> <1.e1, 2> }\n"
        "texture_list { 3, texture { Oak }, texture { pigment { rgb <1,0,0> } } texture{ Elm scale 2 } }\n"
        "face_indices { 3, <0,1,2>,2, <0,1,3>, <1,2,3> 0 1,2, }\n"
        "uv_indices { 3, <0,0,1>, <1,1,0>, <0,1,0> }\n"
        "normal_indices { 2, <0,0,0>, <0,1,0> }\n"
        "inside_vector <0,0,1> uv_mapping hollow on no_shadow interior { ior 1.5 } texture { Pine }\n");
    EXPECT_EQ(mesh.positions, (std::vector<Vec3f>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}));
    EXPECT_EQ(mesh.normals, (std::vector<Vec3f>{{0, 0, 1}, {0, -2, 0}}));
    EXPECT_EQ(mesh.uvs, (std::vector<std::array<float, 2>>{{0.5f, -0.5f}, {10, 2}}));
    EXPECT_EQ(mesh.textures, (std::vector<std::string>{"Oak", "", "Elm"}));
    EXPECT_EQ(mesh.material, "Pine");
    ASSERT_EQ(mesh.faces.size(), 3u);
    constexpr std::uint32_t none = Mesh2Face::none;
    EXPECT_EQ(mesh.faces[1].positions, (Indices{0, 1, 3}));
    EXPECT_EQ(mesh.faces[1].normals, (Indices{0, 1, 0}));
    EXPECT_EQ(mesh.faces[2].normals, (Indices{none, none, none})) << "flat: beyond the normal_indices";
    EXPECT_EQ(mesh.faces[2].uvs, (Indices{0, 1, 0}));
    EXPECT_EQ(mesh.faces[0].textures, (Indices{2, 2, 2}));
    EXPECT_EQ(mesh.faces[1].textures, (Indices{none, none, none}));
    EXPECT_EQ(mesh.faces[2].textures, (Indices{0, 1, 2}));
}

TEST(Mesh2File, NormalsAndUvsWithoutIndicesGoWithTheVertices) {
    const Mesh2 mesh =
        mesh_of(triangle + "normal_vectors { 3, z, z, -z } uv_vectors { 3 <0,0>, <1,0>, <0,1> }");
    EXPECT_EQ(mesh.faces.at(0).normals, (Indices{0, 1, 2}));
    EXPECT_EQ(mesh.faces.at(0).uvs, (Indices{0, 1, 2}));
    EXPECT_EQ(mesh.normals.at(2), Vec3f(0, 0, -1));
}

TEST(Mesh2File, NumbersAndVectorsHavePovraysMeaning) {
    const Mesh2 mesh = mesh_of(
        "vertex_vectors { 9 <-1.5, +2, - .5>, -1.5*x, y*2 z, 2*<1,-2,3>, -<1,2,3>*2, 7, <1e3 1E-3 0>, "
        "<1e999,-1e999,1e-999> } face_indices{1 <0,1.0,2>}");
    const std::vector<Vec3f> expected{{-1.5f, 2, -0.5f}, {-1.5f, 0, 0}, {0, 2, 0}, {0, 0, 1},
                                      {2, -4, 6},        {-2, -4, -6},  {7, 7, 7}, {1000, 0.001f, 0}};
    ASSERT_EQ(mesh.positions.size(), 9u);
    for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(mesh.positions[i], expected[i]) << i;
    EXPECT_TRUE(std::isinf(mesh.positions[8].x) && mesh.positions[8].y < 0 && mesh.positions[8].z == 0);
}

TEST(Mesh2File, TransformationsAreThoseOfPovray) {
    // Results of POV-Ray 3.7 for vtransform(<1,2,3>, transform { ... }) and vrotate.
    const std::string point = "vertex_vectors { 3, <1,2,3>, <1,0,0>, <0,1,0> } face_indices { 1, <0,1,2> } ";
    const struct {
        std::string transformation;
        Vec3d expected;
    } cases[] = {
        {"scale <1,2,3> rotate <10,20,30> matrix <1,2,3, 4,5,7, 7,8,10, 10,11,12> translate <4,5,6>",
         {93.582079299264, 110.840489591305, 140.900690178828}},
        {"rotate <10,20,30>", {1.067425379399, 2.289059482621, 2.760581414202}},
        {"rotate 10*x rotate y*20 transform { rotate 30*z }",
         {1.067425379399, 2.289059482621, 2.760581414202}},
        {"rotate <0,90,0>", {3, 2, -1}},
        {"scale 2", {2, 4, 6}},
        {"scale <0,2,-1>", {1, 4, -3}},
        {"translate 1", {2, 3, 4}},
    };
    for (const auto& [transformation, expected] : cases) {
        const Mesh2 inside = mesh_of(point + transformation);
        EXPECT_LT((Vec3d(inside.positions.at(0)) - expected).length(), 1e-5) << transformation;
        const Mesh2File outside =
            file_of("#declare M = mesh2 { " + point + "}\nobject { M " + transformation + " }");
        ASSERT_EQ(outside.placed.size(), 1u);
        EXPECT_EQ(outside.meshes[0].positions[0], Vec3f(1, 2, 3));
        EXPECT_LT((outside.placed[0].transform.point({1, 2, 3}) - expected).length(), 1e-10)
            << transformation;
    }
}

TEST(Mesh2File, NormalsStayAtRightAnglesAndMirroredFacesAreTurned) {
    // The plane x + y + z = 1.
    const std::string plane =
        "vertex_vectors { 3, x, y, z } normal_vectors { 1, <1,1,1> } face_indices { 1, <0,1,2> } "
        "normal_indices { 1, <0,0,0> } ";
    for (const std::string transformation :
         {"scale <1,2,3>", "scale <-1,2,3> rotate <10,20,30>", "matrix <1,0,0, .5,1,0, 0,2,1, 1,1,1>"}) {
        const Mesh2 mesh = mesh_of(plane + transformation);
        const Indices& corner = mesh.faces.at(0).positions;
        const Vec3f a = mesh.positions[corner[1]] - mesh.positions[corner[0]],
                    b = mesh.positions[corner[2]] - mesh.positions[corner[0]];
        EXPECT_NEAR(mesh.normals[0].dot(a), 0, 1e-6f) << transformation;
        EXPECT_NEAR(mesh.normals[0].dot(b), 0, 1e-6f) << transformation;
        EXPECT_GT(mesh.normals[0].dot(a.cross(b)), 0) << transformation;
    }
}

TEST(Mesh2File, MeshesAreWhereObjectsPlaceThem) {
    const Mesh2File file =
        file_of("#declare DATAa =\nmesh2 { " + triangle + " }\n#local b = mesh2 { " + triangle + " }\n" +
                "mesh2 { " + triangle + " translate x }\n" +
                "union { object { DATAa scale 2 material { Clay } } object { b translate y } translate 10*z "
                "texture { Wood } }\nobject { DATAa matrix <1,0,0, 0,0,1, 0,1,0, 0,0,5> }\n"
                "object { Unknown translate Foo }\nlight_source { <1,1,1> rgb 1 rotate Bar(2) }\n");
    ASSERT_EQ(file.meshes.size(), 3u);
    EXPECT_EQ(file.meshes[0].name, "DATAa");
    EXPECT_EQ(file.meshes[1].name, "b");
    EXPECT_EQ(file.meshes[2].name, "");
    EXPECT_EQ(file.meshes[0].line, 2u);
    EXPECT_EQ(file.meshes[2].line, 4u);
    ASSERT_EQ(file.placed.size(), 4u);
    const struct {
        std::size_t mesh;
        Vec3d of_one_two_three;
        std::string material;
    } expected[] = {{2, {1, 2, 3}, ""}, {0, {2, 4, 16}, "Clay"}, {1, {1, 3, 13}, "Wood"}, {0, {1, 3, 7}, ""}};
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_EQ(file.placed[i].mesh, expected[i].mesh) << i;
        EXPECT_EQ(file.placed[i].transform.point({1, 2, 3}), expected[i].of_one_two_three) << i;
        EXPECT_EQ(file.placed[i].material, expected[i].material) << i;
    }
}

TEST(Mesh2File, UnplacedMeshesAreReadAsDeclared) {
    // The structure of files that PoseRay writes.
    const Mesh2File file =
        file_of("#declare a_ = mesh2 { " + triangle + " }\n#declare b_ = mesh2 { " + triangle +
                " }\n#declare lone_ = mesh2 { " + triangle +
                " }\n#declare all_ = union {\nobject{a_ material{A_}}\nobject{b_ material{B_} "
                "translate x}\n}\n");
    ASSERT_EQ(file.placed.size(), 3u);
    EXPECT_EQ(file.placed[0].mesh, 2u);
    EXPECT_EQ(file.placed[1].mesh, 0u);
    EXPECT_EQ(file.placed[1].material, "A_");
    EXPECT_EQ(file.placed[2].transform.origin, Vec3d(1, 0, 0));
    const Mesh2File placed = file_of("#declare a_ = mesh2 { " + triangle +
                                     " }\n#declare big = object { a_ scale 9 }\nobject { a_ scale 2 }");
    ASSERT_EQ(placed.placed.size(), 1u) << "big is not used";
    EXPECT_EQ(placed.placed[0].transform.axes[0], Vec3d(2, 0, 0));
    const Mesh2File again =
        file_of("#declare a = mesh2 { " + triangle + " }\n#declare a = mesh2 { " + triangle + " }");
    EXPECT_EQ(again.placed.size(), 2u);
}

TEST(Mesh2File, GuardsCommentsStringsAndTexturesInAMeshAreSkipped) {
    const std::string guarded =
        "// mesh2 { }\n/* mesh2 { /* nested */ } */\n#version 3.7;\n#include \"mesh2 {.inc\"\n"
        "#if (version < 3.7) #version 3.5; #end\n#ifndef (Done)\n#declare Done = 1;\n"
        "#ifdef (Other) mesh2 { broken #if (1) #else #end } #else #declare Name = #end\n"
        "mesh2 {" +
        triangle +
        "#declare MAT = texture { pigment { rgb 1 } } texture_list { 1 texture { MAT } } }\n#end\n"
        "#ifndef (Done) mesh2 { broken } #end\n#debug \"a } \\\" b\"\n";
    const Mesh2File file = file_of(guarded);
    ASSERT_EQ(file.meshes.size(), 1u);
    EXPECT_EQ(file.meshes[0].name, "Name");
    EXPECT_EQ(file.meshes[0].textures, std::vector<std::string>{"MAT"});
}

TEST(Mesh2File, ErrorsNameTheLineAndTheReason) {
    const auto mesh = [](const std::string& items) { return "\nmesh2 {\n" + items + "\n}"; };
    const auto replaced = [&](const std::string& from, const std::string& to) {
        std::string text = mesh(triangle);
        return text.replace(text.find(from), from.size(), to);
    };
    const struct {
        std::string text, place, reason;
    } cases[] = {
        {"", "", "has no mesh2"},
        {"#include \"geometry.inc\"", "", "see \"geometry.inc\""},
        {"mesh2 { }", "line 1", "neither"},
        {replaced("3,", "2,"), "line 3", "after the 2 items of vertex_vectors"},
        {replaced("3,", "4,"), "line 3", "ends after 3 of 4"},
        {replaced("3,", "400,"), "line 3", "too short"},
        {replaced("3,", "-3,"), "line 3", "not negative"},
        {replaced("3,", "nx*ny,"), "line 3", "found \"nx*ny\""},
        {replaced("3,", "3.5,"), "line 3", "whole"},
        {replaced("<1,0,0>", "<1,0>"), "line 3", "plain number"},
        {replaced("<1,0,0>", "<1,0,0,0>"), "line 3", "\">\""},
        {replaced("<1,0,0>", "<1,R,0>"), "line 3", "found \"R\""},
        {replaced("<1,0,0>", "<1,2*3,0>"), "line 3", "not an expression"},
        {replaced("<1,0,0>", "<1,0,0>*R"), "line 3", "plain number"},
        {replaced("<1,0,0>", "x+y"), "line 3", "not an expression"},
        {replaced("<1,0,0>", "Corner"), "line 3", "found \"Corner\""},
        {replaced("<1,0,0>", "<nan,0,0>"), "line 3", "plain number"},
        {replaced("<1,0,0>", "<0x7,0,0>"), "line 3", "plain number"},
        {replaced("<1,0,0>", "#if (1) <1,0,0>"), "line 3", "found \"#if\""},
        {replaced("<0,1,2>", "<0,1,3>"), "line 2", "face 0 of a mesh2 has vertex 3; there are 3"},
        {replaced("<0,1,2>", "<0,-1,2>"), "line 3", "not negative"},
        {replaced("<0,1,2>", "<0,1,2>,0"), "line 2", "texture 0; there are 0"},
        {replaced("<0,1,2>", "<0,1,2>,0,0"), "line 3", "two textures"},
        {mesh(triangle + "\nnormal_vectors { 2, z, z }"), "line 2", "no normal_indices"},
        {mesh(triangle + "\nnormal_vectors { 2, z, z } normal_indices { 1, <0,1,2> }"), "line 2", "normal 2"},
        {mesh(triangle + "\nnormal_vectors { 2, z, z } normal_indices { 2, <0,1,0> <0,1,0> }"), "line 2",
         "2 normal_indices for 1 faces"},
        {mesh(triangle + "\nuv_vectors { 2, <0,0>, <0,1> }"), "line 2", "no uv_indices"},
        {mesh(triangle + "\nuv_vectors { 2, <0,0>, <0,1> } uv_indices { 1, <0,1,2> }"), "line 2",
         "uv vector 2"},
        {mesh(triangle + "\nuv_vectors { 2, <0,0>, <0,1> } uv_indices { 2, <0,1,1> <0,1,1> }"), "line 2",
         "2 uv_indices for 1 faces"},
        {mesh(triangle + "\ntexture_list { 1, pigment { rgb 1 } }"), "line 4", "texture { ... }"},
        {mesh(triangle + "\n" + corners), "line 4", "second vertex_vectors"},
        {mesh(triangle + "\n#include \"more.inc\""), "line 4", "#include"},
        {mesh(triangle + "\n#declare R = 2;"), "line 4", "#declare"},
        {mesh(triangle + "\nMaterial(2)"), "line 4", "Material"},
        {mesh(triangle + "\nscale R"), "line 4", "found \"R\""},
        {mesh(triangle + "\nmatrix <1,0,0, 0,1,0, 0,0,1>"), "line 4", "plain number"},
        {mesh(triangle + "\ntransform { T }"), "line 4", "in a transform"},
        {mesh(triangle + "\nclipped_by { plane { x, 0 } }"), "line 4", "clipped_by"},
        {mesh(triangle + "\ntexture { pigment { rgb 1 }"), "line 5", "found the end"},
        {"\nmesh2 {" + triangle, "line 2", "the end"},
        {"\n\n/* mesh2", "line 3", "comment does not end"},
        {"\n\"mesh2", "line 2", "string does not end"},
        {"\n#macro M(a)\n" + mesh(triangle) + "\n#end", "line 4", "#macro of line 2"},
        {"#declare i = 0;\n#while (i < 3)" + mesh(triangle) + "\n#end", "line 3", "#while of line 2"},
        {"#declare A = " + mesh(triangle) + "\n#if (1)\nobject { A }\n#end", "line 6", "#if of line 5"},
        {"#declare A = " + mesh(triangle) + "\nobject { A\nrotate clock*y }", "line 6", "clock"},
        {"difference {" + mesh(triangle) + "box { 0, 1 } }", "line 1", "cut by a difference"},
        {"#declare A = " + mesh(triangle) + "\nobject { A\nclipped_by { box { 0, 1 } } }", "line 6", "cut"},
        {"union {" + mesh(triangle), "line 1", "does not end"},
    };
    for (const auto& [text, place, reason] : cases) {
        const std::string message = message_of(text);
        EXPECT_TRUE(place.empty() || message.starts_with(place + ":")) << text << '\n' << message;
        EXPECT_NE(message.find(reason), std::string::npos) << text << '\n' << message;
    }
}

TEST(Mesh2File, CutShortIsAnError) {
    const std::string whole = example_mesh_files("inc")[0];
    const std::size_t mesh_end = whole.find("#end");
    for (std::size_t size = 0; size < mesh_end - 3; ++size)
        EXPECT_FALSE(read_mesh2(std::string_view(whole).substr(0, size))) << size;
}

TEST(Mesh2File, CountsAndNestingCannotExhaustMemory) {
    EXPECT_NE(message_of("mesh2 { vertex_vectors { 4000000000, <0,0,0> } }").find("too short"),
              std::string::npos);
    EXPECT_NE(message_of(std::string(100000, '{') + "mesh2 {" + triangle + "}").find("too deep"),
              std::string::npos);
    std::string conditions = "#if (1) ";
    for (int i = 0; i < 15; ++i) conditions += conditions;
    EXPECT_NE(message_of(conditions).find("too deep"), std::string::npos);
    std::string doubling = "#declare A0 = mesh2 {" + triangle + "}";
    for (int i = 0; i < 40; ++i) {
        const std::string a = "object { A" + std::to_string(i) + " }";
        doubling += "\n#declare A" + std::to_string(i + 1) + " = union { " + a + a + " }";
    }
    EXPECT_NE(message_of(doubling).find("more than 100000"), std::string::npos);
}

TEST(Mesh2File, DamagedTextsAreReadOrRefused) {
    FuzzRandom random(20240611);
    const std::vector<std::string> files = example_mesh_files("inc");
    std::size_t accepted = 0;
    for (int i = 0; i < 8000; ++i) {
        std::string bytes = files[random_index(random, files.size())];
        damage(bytes, random, files[random_index(random, files.size())], mesh_words());
        const Result<Mesh2File> file = read_mesh2(bytes);
        if (!file) {
            ASSERT_FALSE(file.error().what.empty()) << bytes;
            continue;
        }
        ++accepted;
        std::vector<bool> stands(file->meshes.size(), false);
        for (const PlacedMesh2& placed : file->placed) stands.at(placed.mesh) = true;
        ASSERT_EQ(std::count(stands.begin(), stands.end(), false), 0) << bytes;
        for (const Mesh2& mesh : file->meshes)
            for (const Mesh2Face& face : mesh.faces)
                for (std::size_t k = 0; k < 3; ++k) {
                    ASSERT_LT(face.positions[k], mesh.positions.size()) << bytes;
                    ASSERT_TRUE(face.normals[k] == Mesh2Face::none || face.normals[k] < mesh.normals.size());
                    ASSERT_TRUE(face.uvs[k] == Mesh2Face::none || face.uvs[k] < mesh.uvs.size());
                    ASSERT_TRUE(face.textures[k] == Mesh2Face::none ||
                                face.textures[k] < mesh.textures.size());
                }
    }
    EXPECT_GT(accepted, 500u);
    EXPECT_LT(accepted, 7500u);
}

ImportedMesh imported(const std::string& name, const std::string& text) {
    const TestFolder folder;
    write_text(folder / name, text);
    Result<ImportedMesh> mesh = read_mesh(folder / name);
    EXPECT_TRUE(mesh) << mesh.error().message();
    return mesh ? *std::move(mesh) : ImportedMesh{};
}

TEST(Mesh2File, ReadMeshPlacesMeshesAndNamesTheirMaterials) {
    const std::string two_faces =
        "vertex_vectors { 4, <0,0,0>, <1,0,0>, <0,1,0>, <1,1,0> } texture_list { 2, texture { Oak }, texture "
        "{ "
        "pigment { rgb 1 } } } face_indices { 2, <0,1,2>,0, <1,3,2>,1 }";
    for (const std::string name : {"a.inc", "a.POV", "a.mesh2", "a.txt"}) {
        const ImportedMesh one = imported(name, "mesh2 { " + two_faces + " }");
        EXPECT_EQ(one.mesh.triangles.size(), 2u) << name;
        EXPECT_EQ(one.mesh.material_names, (std::vector<std::string>{"Oak", "1"})) << name;
    }
    const ImportedMesh many =
        imported("b.inc", "#declare A = mesh2 { " + two_faces + " }\n#declare B = mesh2 { " + triangle +
                              " }\n#declare C = mesh2 { " + triangle +
                              " }\nobject { A scale <-1,1,1> }\nobject { B "
                              "translate 5*z material { Clay } }\nobject { C translate 7*z }");
    EXPECT_EQ(many.mesh.triangles.size(), 4u);
    EXPECT_EQ(many.mesh.material_names, (std::vector<std::string>{"Oak", "A 1", "Clay", "C"}));
    const Bounds bounds = mesh_bounds(many.mesh);
    EXPECT_EQ(bounds.lower, Vec3f(-1, 0, 0));
    EXPECT_EQ(bounds.upper, Vec3f(1, 1, 7));
    EXPECT_EQ(many.findings.flipped_triangles, 0u);
    for (const Vec3f& normal : many.mesh.normals) EXPECT_NEAR(std::abs(normal.z), 1, 1e-6f);
    // Blender writes an empty texture for a mesh without a material.
    const std::string plain = "mesh2 { " + triangle + " texture_list { 1 texture{} } }";
    EXPECT_EQ(imported("d.inc", plain).mesh.material_names, std::vector<std::string>{""});
    EXPECT_EQ(imported("e.inc", "#declare D = " + plain + "#declare E = " +
                                    std::string(plain).replace(plain.find("<0,1,2>"), 7, "<0,1,2>,0") +
                                    "object { E translate z }")
                  .mesh.material_names,
              (std::vector<std::string>{"E", "D"}));
    // Blended textures are colours.
    const ImportedMesh coloured =
        imported("c.inc", "mesh2 { " + corners +
                              " texture_list { 3 texture { pigment { rgb x } } texture { pigment { rgb y } } "
                              "texture { pigment { rgb z } } } face_indices { 1, <0,1,2>,0,1,2 } }");
    EXPECT_EQ(coloured.mesh.material_names, std::vector<std::string>{""});
}

TEST(Mesh2File, ReadMeshSaysWhatIsWrongWithATextAndWhere) {
    const TestFolder folder;
    write_text(folder / "a.inc", "\nmesh2 { vertex_vectors { N } }");
    const Result<ImportedMesh> mesh = read_mesh(folder / "a.inc");
    ASSERT_FALSE(mesh);
    EXPECT_NE(mesh.error().message().find("a.inc: "), std::string::npos);
    EXPECT_NE(mesh.error().message().find("line 2: found \"N\"; expected a plain number"), std::string::npos)
        << mesh.error().message();
}

}  // namespace
}  // namespace haarfield
