#include "fields/mesh/listed_mesh.h"

#include "fields/mesh/mesh_subdivision.h"
#include "fields/model/model_file.h"
#include "fields/preparation/mesh_preparation.h"
#include "tests/fixtures/example_meshes.h"
#include "tests/fixtures/test_folder.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <random>
#include <set>

namespace haarfield {
namespace {

using Corners = std::vector<std::uint32_t>;

/// Vertices: two are equal, one is unused, and one is used only by a face without area. Includes a quad.
const std::string vertices[] = {"0 0 0", "1 0 0", "1 1 0", "0 1 0", "1 0 0",
                                "2 0 0", "2 1 0", "9 9 9", "5 5 5"};

std::string ply_text() {
    std::string text =
        "ply\nformat ascii 1.0\nelement vertex 9\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 3\nproperty list uchar int vertex_indices\nend_header\n";
    for (const std::string& vertex : vertices) text += vertex + "\n";
    return text + "4 0 1 2 3\n3 4 5 6\n3 8 8 0\n";
}

/// Returns these faces, with the second one in another object and with negative numbers.
std::string obj_text() {
    std::string text = "o one\n";
    for (const std::string& vertex : vertices) text += "v " + vertex + "\n";
    return text + "f 1 2 3 4\no two\nf -5 -4 \\\n-3\nf 9 9 1\n";
}

class ListedMeshes : public testing::Test {
protected:
    ModelFile opened(const std::string& name, const std::string& text) {
        write_text(folder / name, text);
        Result<ModelFile> model = ModelFile::open(folder / name);
        EXPECT_TRUE(model) << model.error().message();
        return *std::move(model);
    }

    const TestFolder folder;
};

/// Tests whether each vertex of a mesh is at the position of the file's vertex with its number.
void expect_right_numbers(const Mesh& mesh, const ListedMesh& listed, const std::string& of) {
    ASSERT_EQ(mesh.original_vertices.size(), mesh.positions.size()) << of;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        const auto found = std::ranges::lower_bound(listed.numbers, mesh.original_vertices[v]);
        ASSERT_TRUE(found != listed.numbers.end() && *found == mesh.original_vertices[v]) << of << " " << v;
        EXPECT_EQ(mesh.positions[v], listed.positions[std::size_t(found - listed.numbers.begin())])
            << of << " " << v;
    }
}

TEST_F(ListedMeshes, HaveTheVerticesAndFacesOfTheFileInItsOrder) {
    std::string off = "OFF\n9 3 0\n";
    for (const std::string& vertex : vertices) off += vertex + "\n";
    off += "4 0 1 2 3\n3 4 5 6\n3 8 8 0\n";
    for (const auto& [name, text] : {std::pair("a.ply", ply_text()), {"a.off", off}, {"a.obj", obj_text()}}) {
        const ModelFile model = opened(name, text);
        const Result<ListedMesh> listed = model.listed();
        ASSERT_TRUE(listed) << name;
        ASSERT_EQ(listed->positions.size(), 9u) << name;
        for (std::size_t v = 0; v < 9; ++v) {
            EXPECT_EQ(fmt::format("{} {} {}", listed->positions[v].x, listed->positions[v].y,
                                  listed->positions[v].z),
                      vertices[v])
                << name;
            EXPECT_EQ(listed->numbers[v], std::int32_t(v));
        }
        EXPECT_EQ(listed->face_corners, (Corners{4, 3, 3})) << name;
        EXPECT_EQ(listed->corners, (Corners{0, 1, 2, 3, 4, 5, 6, 8, 8, 0})) << name;
        for (const bool originals : {false, true}) {
            const Result<ImportedMesh> imported = read_mesh(model, {}, {.originals = originals});
            ASSERT_TRUE(imported);
            expect_right_numbers(imported->mesh, *listed, name);
            // Vertices 1 and 4 are equal.
            std::multiset<std::int32_t> used(imported->mesh.original_vertices.begin(),
                                             imported->mesh.original_vertices.end());
            EXPECT_EQ(used.count(4), originals ? 1u : 0u) << name;
            EXPECT_EQ(used.size(), originals ? 7u : 6u) << name;
        }
    }
}

TEST_F(ListedMeshes, OfAPartOfAnObjFileKeepTheFilesNumbers) {
    const ModelFile model = opened("a.obj", obj_text());
    ASSERT_EQ(model.parts().names.size(), 2u);
    const Result<ListedMesh> listed = model.listed(1);
    ASSERT_TRUE(listed);
    EXPECT_EQ(listed->numbers, (std::vector<std::int32_t>{0, 4, 5, 6, 8}));
    EXPECT_EQ(listed->corners, (Corners{1, 2, 3, 4, 4, 0}));
    EXPECT_EQ(listed->positions[4], Vec3f(5, 5, 5));
    const Result<ImportedMesh> imported = read_mesh(model, 1, {});
    ASSERT_TRUE(imported);
    expect_right_numbers(imported->mesh, *listed, "part");
}

/// Objects that are continued, changing materials, n-gons, vertices at equal positions.
TEST_F(ListedMeshes, KeepTheirNumbersForAnyObjFile) {
    for (unsigned seed = 0; seed < 20; ++seed) {
        std::mt19937 random(seed);
        std::string text;
        int count = 0;
        for (int i = 0; i < 120; ++i) {
            if (i % 7 == 0) text += fmt::format("o part{}\n", random() % 3);
            if (i % 5 == 0) text += fmt::format("usemtl m{}\n", random() % 3);
            const unsigned corners = 3 + random() % 3;
            const double height = double(random() % 4) / 3, turn = double(random() % 8), size = 0.1 * (i + 1);
            for (unsigned k = 0; k < corners; ++k)
                text += fmt::format("v {:.9g} {:.9g} {:.9g}\n", size * std::cos(turn + 6.28 * k / corners),
                                    height, size * std::sin(turn + 6.28 * k / corners));
            count += int(corners);
            text += "f";
            for (unsigned k = 0; k < corners; ++k)
                text += random() % 2 ? fmt::format(" {}", count - int(corners) + int(k) + 1)
                                     : fmt::format(" {}", int(k) - int(corners));
            text += "\n";
        }
        const ModelFile model = opened(fmt::format("{}.obj", seed), text);
        const Result<ListedMesh> listed = model.listed();
        ASSERT_TRUE(listed);
        EXPECT_EQ(listed->positions.size(), std::size_t(count));
        EXPECT_EQ(listed->face_corners.size(), 120u);
        const Result<ImportedMesh> imported = read_mesh(model, {}, {.originals = true});
        ASSERT_TRUE(imported) << imported.error().message();
        expect_right_numbers(imported->mesh, *listed, fmt::format("seed {}", seed));
        const std::set<std::int32_t> used(imported->mesh.original_vertices.begin(),
                                          imported->mesh.original_vertices.end());
        EXPECT_EQ(used.size(), std::size_t(count)) << seed;
    }
}

TEST_F(ListedMeshes, AreWhereTheFilePlacesThem) {
    const std::string mesh2 =
        "#declare A = mesh2 { vertex_vectors { 4, <0,0,0>, <1,0,0>, <0,1,0>, <7,7,7> } face_indices { 1, "
        "<0,1,2> } }\nobject { A scale <-1, 1, 1> translate <5, 0, 0> }\nobject { A }\n";
    const ModelFile model = opened("a.inc", mesh2);
    const Result<ListedMesh> whole = model.listed(), part = model.listed(0);
    ASSERT_TRUE(whole && part);
    EXPECT_EQ(part->positions.size(), 4u);
    EXPECT_EQ(part->corners, (Corners{0, 1, 2}));
    ASSERT_EQ(whole->positions.size(), 8u);
    EXPECT_EQ(whole->positions[1], Vec3f(4, 0, 0));
    EXPECT_EQ(whole->positions[5], Vec3f(1, 0, 0));
    EXPECT_EQ(whole->corners, (Corners{0, 2, 1, 4, 5, 6})) << "the mirrored face is reversed";
    const Result<ImportedMesh> imported = read_mesh(model, {}, {.originals = true});
    ASSERT_TRUE(imported);
    expect_right_numbers(imported->mesh, *whole, "mesh2");
    EXPECT_EQ(std::ranges::count(imported->mesh.original_vertices, 5), 1);

    const std::string stl =
        "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
        "0\nendloop\nendfacet\n"
        "facet normal 0 0 1\nouter loop\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\nendloop\nendfacet\n"
        "endsolid a\n";
    const ModelFile facets = opened("a.stl", stl);
    const Result<ListedMesh> corners = facets.listed();
    ASSERT_TRUE(corners);
    ASSERT_EQ(corners->positions.size(), 6u);
    EXPECT_EQ(corners->positions[4], Vec3f(1, 1, 0));
    EXPECT_EQ(corners->corners, (Corners{0, 1, 2, 3, 4, 5}));
}

/// A triangle with two placements, the second one mirrored.
TEST_F(ListedMeshes, OfNodesHaveTheVerticesOfEach) {
    const std::string gltf = R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],
"nodes":[{"mesh":0,"translation":[1,2,3],"rotation":[0.5,0.5,0.5,0.5]},{"mesh":0,"scale":[-1,1,0.5]}],
"meshes":[{"name":"leaf","primitives":[{"attributes":{"POSITION":0}}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":36}],
"buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})";
    const ModelFile model = opened("a.gltf", gltf);
    const Result<ListedMesh> whole = model.listed(), part = model.listed(0);
    ASSERT_TRUE(whole && part);
    EXPECT_EQ(part->positions, (std::vector<Vec3f>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
    ASSERT_EQ(whole->positions.size(), 6u);
    EXPECT_EQ(whole->positions[4], Vec3f(-1, 0, 0));
    EXPECT_EQ(whole->corners, (Corners{0, 1, 2, 3, 5, 4}));
    const Result<ImportedMesh> imported = read_mesh(model, {}, {.originals = true});
    ASSERT_TRUE(imported);
    expect_right_numbers(imported->mesh, *whole, "glTF");
}

/// An upright sheet, so that its back is visible.
TEST_F(ListedMeshes, CreatedVerticesHaveNoNumbers) {
    const ModelFile model = opened("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
    Result<ImportedMesh> imported = read_mesh(model, {}, {});
    ASSERT_TRUE(imported);
    const Result<PreparedMesh> prepared = prepare_mesh(*std::move(imported), {.fine_vertices = 100});
    ASSERT_TRUE(prepared);
    const Mesh& fine = prepared->fine;
    ASSERT_FALSE(prepared->backs.triangles.empty());
    ASSERT_EQ(fine.original_vertices.size(), fine.positions.size());
    EXPECT_GE(fine.positions.size(), 100u);
    EXPECT_EQ(std::ranges::count(fine.original_vertices, not_original),
              std::ptrdiff_t(fine.positions.size()) - 4);
    const std::set<std::int32_t> first(fine.original_vertices.begin(), fine.original_vertices.begin() + 4);
    EXPECT_EQ(first, (std::set<std::int32_t>{0, 1, 2, 3}));
    EXPECT_TRUE(subdivided(square_mesh(1, 0, 1), 100).original_vertices.empty()) << "of no file";
}

}  // namespace
}  // namespace haarfield
