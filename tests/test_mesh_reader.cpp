#include "fields/model/mesh_reader.h"

#include "fields/mesh/polygon_triangulation.h"
#include "tests/fixtures/mesh_measures.h"
#include "tests/fixtures/random_numbers.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <fstream>
#include <random>
#include <set>

namespace haarfield {

namespace {

/// A file that exists during a test.
struct TextFile {
    std::filesystem::path path;

    TextFile(const std::string& name, const std::string& text) {
        const testing::TestInfo* test = testing::UnitTest::GetInstance()->current_test_info();
        path = std::filesystem::path(testing::TempDir()) / (std::string(test->name()) + "-" + name);
        std::ofstream(path, std::ios::binary) << text;
    }
    TextFile(const TextFile&) = delete;
    ~TextFile() { std::filesystem::remove(path); }
};

ImportedMesh read(const std::string& name, const std::string& text, const MeshReaderOptions& options = {}) {
    const TextFile file(name, text);
    Result<ImportedMesh> imported = read_mesh(file.path, options);
    EXPECT_TRUE(imported) << (imported ? "" : imported.error().message());
    return imported ? *std::move(imported) : ImportedMesh{};
}

const char* const cube_corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n";
const char* const cube_faces = "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 4 1 5 8\n";

/// Returns a tube of `sides` quads, without normals.
std::string tube_obj(int sides) {
    std::string text;
    for (int i = 0; i < sides; ++i) {
        const double a = 2 * pi * i / sides;
        for (int y = 0; y < 2; ++y)
            text += "v " + std::to_string(std::cos(a)) + " " + std::to_string(y) + " " +
                    std::to_string(std::sin(a)) + "\n";
    }
    for (int i = 0; i < sides; ++i) {
        const int a = 2 * i + 1, b = 2 * ((i + 1) % sides) + 1;
        text += "f " + std::to_string(a) + " " + std::to_string(a + 1) + " " + std::to_string(b + 1) + " " +
                std::to_string(b) + "\n";
    }
    return text;
}

}  // namespace

TEST(MeshReader, CubeKeepsItsEdgesSharp) {
    const ImportedMesh cube = read("cube.obj", std::string(cube_corners) + cube_faces);
    EXPECT_EQ(cube.mesh.triangles.size(), 12u);
    EXPECT_EQ(cube.mesh.positions.size(), 24u);
    EXPECT_EQ(cube.findings.polygons, 6u);
    EXPECT_EQ(cube.findings.duplicate_vertices, 16u);
    EXPECT_EQ(cube.findings.components, 1u);
    EXPECT_EQ(cube.findings.open_components, 0u);
    EXPECT_NEAR(signed_volume(cube.mesh), 1, 1e-6);
    for (const Vec3f& n : cube.mesh.normals) {
        EXPECT_NEAR(n.length(), 1, 1e-6);
        EXPECT_NEAR(std::max({std::abs(n.x), std::abs(n.y), std::abs(n.z)}), 1, 1e-6);
    }
}

TEST(MeshReader, ObjNumbersNeedNoLeadingZero) {
    const Mesh mesh =
        read("dots.obj", "v -.5 0 -.5\nv .5 0 -.5\nv .5 0 .5\nv -.5 0 +.5\nusemtl .5\nf 1 4 3 2\n").mesh;
    const Bounds bounds = mesh_bounds(mesh);
    EXPECT_EQ(bounds.lower, Vec3f(-0.5f, 0, -0.5f));
    EXPECT_EQ(bounds.upper, Vec3f(0.5f, 0, 0.5f));
    EXPECT_EQ(mesh.material_names, std::vector<std::string>{".5"});
}

TEST(MeshReader, CreaseAngleDecidesWhatIsSmooth) {
    const MeshReaderOptions sharp{0.30f};  // faces of the tube meet at 30 degrees, 0.52 rad
    const ImportedMesh smooth_tube = read("smooth.obj", tube_obj(12));
    const ImportedMesh sharp_tube = read("sharp.obj", tube_obj(12), sharp);
    EXPECT_EQ(smooth_tube.mesh.positions.size(), 24u);
    EXPECT_EQ(sharp_tube.mesh.positions.size(), 48u);
    for (std::size_t i = 0; i < smooth_tube.mesh.positions.size(); ++i) {
        const Vec3f p = smooth_tube.mesh.positions[i], n = smooth_tube.mesh.normals[i];
        EXPECT_NEAR(n.dot(Vec3f(p.x, 0, p.z)), 1, 1e-5) << "vertex " << i;
    }
}

TEST(MeshReader, AFanOfVeryManyTrianglesIsSmoothAndStillHasCreases) {
    // Two discs with many sides share their centre: one level, one upright.
    for (const int sides : {200, 3000}) {
        std::string text = "v 0 0 0\n";
        for (int i = 0; i < sides; ++i) {
            const double a = 2 * pi * i / sides;
            const std::string x = std::to_string(std::cos(a)), y = std::to_string(std::sin(a));
            text += "v " + x + " 0.1 " + y + "\nv " + x + " " + y + " 0\n";
        }
        for (int i = 0; i < sides; ++i) {
            const int a = 2 * i + 2, b = 2 * ((i + 1) % sides) + 2;
            text += "f 1 " + std::to_string(b) + " " + std::to_string(a) + "\nf 1 " + std::to_string(a + 1) +
                    " " + std::to_string(b + 1) + "\n";
        }
        const ImportedMesh fan = read("fan.obj", text);
        ASSERT_EQ(fan.mesh.triangles.size(), std::size_t(2 * sides));
        int level = 0, upright = 0;
        for (std::size_t v = 0; v < fan.mesh.positions.size(); ++v) {
            if (fan.mesh.positions[v] != Vec3f(0.0f)) continue;
            const Vec3f& normal = fan.mesh.normals[v];
            EXPECT_NEAR(std::max(std::abs(normal.y), std::abs(normal.z)), 1, 1e-3) << sides << ": " << normal;
            ++(std::abs(normal.y) > 0.5f ? level : upright);
        }
        EXPECT_GT(level, 0);
        EXPECT_GT(upright, 0);
        EXPECT_LT(level + upright, sides == 200 ? 4 * sides : 64) << sides;
    }
}

TEST(MeshReader, NormalsOfTheFileAreKeptAndNormalised) {
    const ImportedMesh one =
        read("one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 3 4\nvn 0 0 2\nf 1//1 2//2 3//2\n");
    ASSERT_EQ(one.mesh.normals.size(), 3u);
    EXPECT_NEAR(one.mesh.normals[0].y, 0.6, 1e-6);
    EXPECT_NEAR(one.mesh.normals[0].z, 0.8, 1e-6);
    EXPECT_NEAR(one.mesh.normals[1].z, 1, 1e-6);
}

TEST(MeshReader, ZeroNormalsAreComputed) {
    const ImportedMesh one = read("one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 0\nf 1//1 2//1 3//1\n");
    ASSERT_EQ(one.mesh.normals.size(), 3u);
    for (const Vec3f& n : one.mesh.normals) EXPECT_NEAR(n.z, 1, 1e-6);
}

TEST(MeshReader, VerticesAreSplitBetweenMaterials) {
    const ImportedMesh two = read("two.obj",
                                  "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl oak\nf 1 2 3\n"
                                  "usemtl fabric\nf 1 3 4\n");
    ASSERT_EQ(two.mesh.material_names.size(), 2u);
    EXPECT_EQ(two.mesh.positions.size(), 6u);
    for (const auto& t : two.mesh.triangles)
        for (std::uint32_t corner : t)
            EXPECT_EQ(two.mesh.vertex_materials[corner], two.mesh.vertex_materials[t[0]]);
    const std::set<std::string> names(two.mesh.material_names.begin(), two.mesh.material_names.end());
    EXPECT_EQ(names, (std::set<std::string>{"oak", "fabric"}));
}

TEST(MeshReader, AFileWithoutMaterialsHasTheUnnamedOne) {
    const ImportedMesh one = read("one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    EXPECT_EQ(one.mesh.material_names, std::vector<std::string>{""});
}

TEST(MeshReader, BadTrianglesAreLeftOutAndCounted) {
    const ImportedMesh one = read("bad.obj",
                                  "v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 0\nv 2 0 0\nv 0 0 0\n"
                                  "f 1 2 3\nf 1 2 5\nf 1 1 3\nf 2 3 6\nf 3 2 1\nf 1 2 4\n");
    EXPECT_EQ(one.mesh.triangles.size(), 1u);
    EXPECT_EQ(one.findings.degenerate_triangles, 2u);
    EXPECT_EQ(one.findings.duplicate_triangles, 2u);
    EXPECT_EQ(one.findings.non_finite_vertices, 1u);
    EXPECT_EQ(one.findings.boundary_edges, 3u);
    EXPECT_EQ(one.findings.open_components, 1u);
}

TEST(MeshReader, InsideOutAndMixedCubesComeOutOutwards) {
    const std::string inside_out = "f 1 2 3 4\nf 8 7 6 5\nf 5 6 2 1\nf 7 8 4 3\nf 6 7 3 2\nf 8 5 1 4\n";
    const std::string mixed = "f 1 2 3 4\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 4 1 5 8\n";
    const ImportedMesh first = read("inside.obj", cube_corners + inside_out);
    EXPECT_NEAR(signed_volume(first.mesh), 1, 1e-6);
    EXPECT_EQ(first.findings.flipped_triangles, 12u);
    const ImportedMesh second = read("mixed.obj", cube_corners + mixed);
    EXPECT_NEAR(signed_volume(second.mesh), 1, 1e-6);
    EXPECT_EQ(second.findings.flipped_triangles, 2u);
    for (const auto& t : second.mesh.triangles)
        for (std::uint32_t corner : t)
            EXPECT_GT(second.mesh.normals[corner].dot(second.mesh.positions[corner] - Vec3f(0.5f)), 0.4f);
}

TEST(MeshReader, OtherFormatsGiveTheSameCube) {
    const std::string off =
        "OFF\n8 6 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n4 3 2 1 0\n4 4 5 6 7\n"
        "4 0 1 5 4\n4 2 3 7 6\n4 1 2 6 5\n4 3 0 4 7\n";
    const std::string ply =
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 6\nproperty list uchar int vertex_indices\nend_header\n" +
        off.substr(off.find("0 0 0\n1"));
    for (const ImportedMesh& cube : {read("cube.off", off), read("cube.ply", ply)}) {
        EXPECT_EQ(cube.mesh.positions.size(), 24u);
        EXPECT_EQ(cube.mesh.triangles.size(), 12u);
        EXPECT_NEAR(signed_volume(cube.mesh), 1, 1e-6);
    }
}

TEST(MeshReader, NodesOfGltfAreTransformedAndMirroredOnesStillFaceOutwards) {
    // one triangle with corners 0, x, y; the node translates by (0, 5, 0) and mirrors in x
    const std::string gltf = R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
"nodes":[{"mesh":0,"translation":[0,5,0],"scale":[-2,1,1]}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
"buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,)"
                             "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"
                             R"("}],
"bufferViews":[{"buffer":0,"byteLength":36}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}]})";
    const ImportedMesh one = read("one.gltf", gltf);
    ASSERT_EQ(one.mesh.triangles.size(), 1u);
    const Bounds bounds = mesh_bounds(one.mesh);
    EXPECT_NEAR(bounds.lower.x, -2, 1e-6);
    EXPECT_NEAR(bounds.lower.y, 5, 1e-6);
    EXPECT_NEAR(bounds.upper.y, 6, 1e-6);
    EXPECT_NEAR(one.mesh.normals[0].z, 1, 1e-6);
}

TEST(MeshReader, RefusesOtherFiles) {
    const std::filesystem::path missing = std::filesystem::path(testing::TempDir()) / "no-such.obj";
    const Result<ImportedMesh> nothing = read_mesh(missing);
    ASSERT_FALSE(nothing);
    EXPECT_EQ(nothing.error().where, missing.string());
    for (const auto& [name, text] : std::vector<std::pair<std::string, std::string>>{
             {"empty.obj", ""},
             {"empty.ply", ""},
             {"empty.off", ""},
             {"points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\np 1 2 3\n"},
             {"flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"},
             {"nan.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"},
             {"far.obj", "v 2e6 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"},
             {"index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n"},
             {"many.off", "OFF\n353535235358 6 0\n0 0 0\n"},
             {"many.ply", "ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\nend_header\n"},
             {"long.glb", std::string("glTF\2\0\0\0\x18\0\0\0\xff\xff\xff\xffJSON{}  ", 24)},
             {"words.xyzzy", "hello"}}) {
        const TextFile file(name, text);
        EXPECT_FALSE(read_mesh(file.path)) << name;
    }
    for (const char* name : {"words.xyzzy", "words", "words.obj", "words.fbx"}) {
        const TextFile file(name, "hello");
        const std::string message = read_mesh(file.path).error().message();
        EXPECT_NE(message.find("expected OBJ, PLY, glTF (.gltf, .glb), STL, OFF or POV-Ray's mesh2"),
                  std::string::npos)
            << message;
    }
}

TEST(MeshReader, AFileCutShortAnywhereIsAnErrorOrAMesh) {
    const std::string off = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";
    const std::string obj = std::string(cube_corners) + cube_faces;
    for (const auto& [name, text] :
         std::vector<std::pair<std::string, std::string>>{{"cut.off", off}, {"cut.obj", obj}})
        for (std::size_t length = 0; length < text.size(); ++length) {
            const TextFile file(name, text.substr(0, length));
            const Result<ImportedMesh> imported = read_mesh(file.path);
            if (!imported) continue;
            for (const auto& t : imported->mesh.triangles)
                for (std::uint32_t corner : t) ASSERT_LT(corner, imported->mesh.positions.size());
        }
}

TEST(MeshFindings, SummaryNamesOnlyAnomalies) {
    MeshFindings findings;
    findings.components = 3;
    findings.duplicate_vertices = 16;
    EXPECT_EQ(findings.summary(), "");
    findings.polygons = 312;
    findings.boundary_edges = 18;
    findings.open_components = 2;
    EXPECT_EQ(findings.summary(), "312 n-gons triangulated, 18 open edges in 2 of 3 pieces");
}

TEST(Triangulation, KeepsTheAreaOfConcavePolygons) {
    std::mt19937 random(2006);
    for (int corners = 3; corners < 60; ++corners) {  // star-shaped, so that they do not intersect themselves
        std::vector<Vec3f> polygon;
        for (int i = 0; i < corners; ++i) {
            const double a = 2 * pi * i / corners, r = uniform(random, 0.2, 1.0);
            polygon.emplace_back(static_cast<float>(r * std::cos(a)), static_cast<float>(r * std::sin(a)), 7);
        }
        double wanted = 0, sum = 0;
        for (int i = 0; i < corners; ++i)
            wanted += Vec3d(polygon[i]).cross(Vec3d(polygon[(i + 1) % corners])).z;
        const auto triangles = triangulated(polygon);
        ASSERT_EQ(triangles.size(), polygon.size() - 2);
        for (const auto& t : triangles) {
            const double area = (Vec3d(polygon[t[1]]) - Vec3d(polygon[t[0]]))
                                    .cross(Vec3d(polygon[t[2]]) - Vec3d(polygon[t[0]]))
                                    .z;
            EXPECT_GE(area, 0) << corners << " corners";
            sum += area;
        }
        EXPECT_NEAR(sum, wanted, 1e-5) << corners << " corners";
    }
}

TEST(Triangulation, ARoundPolygonGetsNoFan) {
    std::vector<Vec3f> disc;
    for (int i = 0; i < 32; ++i)
        disc.emplace_back(static_cast<float>(std::cos(2 * pi * i / 32)), 0.0f,
                          static_cast<float>(std::sin(2 * pi * i / 32)));
    std::vector<int> uses(disc.size(), 0);
    for (const auto& t : triangulated(disc))
        for (std::uint32_t corner : t) ++uses[corner];
    EXPECT_LE(*std::max_element(uses.begin(), uses.end()), 12);
}

}  // namespace haarfield
