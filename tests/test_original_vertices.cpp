#include "scenes/original_vertices.h"

#include "bridge/files/glb_file.h"
#include "bridge/files/mesh_file.h"
#include "fields/model/model_file.h"
#include "fields/model/polygon_file.h"
#include "tests/fixtures/example_textures.h"
#include "tests/fixtures/test_folder.h"

#include <assimp/version.h>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <set>
#include <sstream>

namespace haarfield {
namespace {

void prepare_with_original_vertices(const Scene& scene, SceneEntities& entities) {
    SceneEntityOptions options;
    options.fields = FieldExtent::none;
    options.original_vertices = true;
    Result<SceneEntities> prepared = prepare_scene_entities(scene, options);
    ASSERT_TRUE(prepared) << prepared.error().message();
    entities = *std::move(prepared);
}

/// Prepares a file of vertices and faces, and assigns radiance to its fine vertices.
class OriginalVertices : public testing::Test {
protected:
    /// Prepares a file. vertices, faces: lines of an OFF file.
    void prepare(const std::vector<std::string>& vertices, const std::vector<std::string>& faces,
                 const Shape& shape = {}) {
        std::string text = fmt::format("OFF\n{} {} 0\n", vertices.size(), faces.size());
        for (const auto& lines : {vertices, faces})
            for (const std::string& line : lines) text += line + "\n";
        write_text(folder / "a.off", text);
        Scene scene;
        Entity& entity = scene.entities.emplace_back();
        entity.name = "a";
        entity.mesh = folder / "a.off";
        scene.instances.push_back({"first", 0, {}, shape});
        scene.instances.push_back({"second", 0, {{3, 0, 0}, 2}, shape});
        prepare_with_original_vertices(scene, entities);
    }
    const Mesh& fine() const { return entities.entities[0]->mesh.fine; }

    /// Returns the bake with radiance as a function of the fine vertex.
    template <class RadianceOf>
    OriginalBake baked(const RadianceOf& radiance_of) {
        radiance.clear();
        for (std::uint32_t v = 0; v < fine().positions.size(); ++v) radiance.push_back(radiance_of(v));
        instances.clear();
        for (const char* name : {"first", "second"}) {
            instances.push_back({name, &fine(), {}, radiance});
            instances.back().passes = {{"occlusion", radiance, true}};
        }
        return original_bake(entities, instances, false);
    }

    const TestFolder folder;
    SceneEntities entities;
    std::vector<Rgb> radiance;
    std::vector<BakedInstance> instances;
};

Rgb by_normal(const Vec3f& n) {
    return {std::abs(n.x), std::abs(n.y), std::abs(n.z)};
}

const std::vector<std::string> cube_vertices{"0 0 0", "1 0 0", "1 1 0", "0 1 0",
                                             "0 0 1", "1 0 1", "1 1 1", "0 1 1"},
    cube_faces{"4 3 2 1 0", "4 4 5 6 7", "4 0 1 5 4", "4 2 3 7 6", "4 1 2 6 5", "4 3 0 4 7"};

/// For any diagonals of its quads.
TEST_F(OriginalVertices, OfACubeHaveTheMeanOfItsSides) {
    prepare(cube_vertices, cube_faces);
    EXPECT_EQ(fine().positions.size(), 24u);
    const OriginalBake bake = baked([&](std::uint32_t v) { return by_normal(fine().normals[v]); });
    EXPECT_EQ(bake.vertices, 16u);
    EXPECT_EQ(bake.unvalued, 0u);
    ASSERT_EQ(bake.instances.size(), 2u);
    const BakedInstance& first = bake.instances[0];
    ASSERT_EQ(first.radiance.size(), 8u);
    for (std::size_t v = 0; v < 8; ++v) {
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(first.radiance[v][c], 1 / 3.0, 1e-6) << v;
        EXPECT_NEAR(first.passes[0].values[v].x, 1 / 3.0, 1e-6) << v;
        const Vec3f outwards = (first.mesh->positions[v] - Vec3f(0.5f, 0.5f, 0.5f)).normalized();
        EXPECT_LT((first.mesh->normals[v] - outwards).length(), 1e-5f) << v;
    }
    EXPECT_EQ(first.mesh, bake.instances[1].mesh) << "shared";
    EXPECT_TRUE(first.passes[0].is_scalar);
}

TEST_F(OriginalVertices, AreBitIdenticalToTheBakedVertex) {
    prepare({"0 0 0", "1 0 0", "1 0 1", "0 0 1"}, {"4 3 2 1 0"});
    ASSERT_EQ(fine().positions.size(), 4u);
    const auto value = [](std::uint32_t v) { return Rgb(0.1f * float(v) + 0.7f, 1 / (3.0f + float(v)), 7); };
    const OriginalBake bake = baked(value);
    for (std::uint32_t v = 0; v < 4; ++v)
        EXPECT_EQ(bake.instances[0].radiance[std::size_t(fine().original_vertices[v])], value(v));
}

/// Two adjacent quads with duplicated common vertices.
TEST_F(OriginalVertices, ThatAreEqualHaveEqualLight) {
    prepare({"0 0 0", "1 0 0", "1 0 1", "0 0 1", "1 0 0", "2 0 0", "2 0 1", "1 0 1"},
            {"4 3 2 1 0", "4 7 6 5 4"});
    const OriginalBake bake =
        baked([&](std::uint32_t v) { return Rgb(fine().positions[v].x, fine().positions[v].z, 1); });
    ASSERT_EQ(bake.meshes[0].positions.size(), 8u);
    const auto seen = bake.instances[0].radiance;
    EXPECT_EQ(seen[1], seen[4]);
    EXPECT_EQ(seen[2], seen[7]);
    for (std::size_t v = 0; v < 8; ++v)
        EXPECT_EQ(seen[v], Rgb(bake.meshes[0].positions[v].x, bake.meshes[0].positions[v].z, 1)) << v;
}

/// An upright sheet, duplicated with reversed faces and separate vertices. The duplicate is removed, but its
/// side is baked.
TEST_F(OriginalVertices, OfASheetsOtherSideHaveThatSidesLight) {
    prepare({"0 0 0", "1 0 0", "1 1 0", "0 1 0", "0 0 0", "1 0 0", "1 1 0", "0 1 0"},
            {"3 0 1 2", "3 0 2 3", "3 6 5 4", "3 7 6 4"});
    EXPECT_EQ(entities.entities[0]->mesh.findings.duplicate_triangles, 2u);
    EXPECT_EQ(fine().positions.size(), 8u) << "with its back";
    const OriginalBake bake =
        baked([&](std::uint32_t v) { return Rgb(fine().normals[v].z > 0 ? 1.0f : 5.0f); });
    EXPECT_EQ(bake.unvalued, 0u);
    for (std::size_t v = 0; v < 8; ++v) {
        EXPECT_EQ(bake.instances[0].radiance[v], Rgb(v < 4 ? 1.0f : 5.0f)) << v;
        EXPECT_EQ(bake.meshes[0].normals[v], Vec3f(0, 0, v < 4 ? 1 : -1)) << v;
    }
}

TEST_F(OriginalVertices, OfASheetHaveItsFront) {
    prepare({"0 0 0", "1 0 0", "1 1 0", "0 1 0"}, {"4 0 1 2 3"});
    EXPECT_EQ(fine().positions.size(), 8u);
    const OriginalBake bake =
        baked([&](std::uint32_t v) { return Rgb(fine().normals[v].z > 0 ? 1.0f : 5.0f); });
    for (const Rgb& seen : bake.instances[0].radiance) EXPECT_EQ(seen, Rgb(1.0f));
}

/// Vertex 4 is unused, and 5 is used only by a degenerate face. So is 6, but at the position of vertex 2. 7
/// is not finite.
TEST_F(OriginalVertices, WithoutATriangleHaveTheValueAtTheirPositionOrNone) {
    prepare({"0 0 0", "1 0 0", "1 0 1", "0 0 1", "9 9 9", "5 5 5", "1 0 1", "nan 0 0"},
            {"4 3 2 1 0", "3 5 5 5", "3 6 6 6", "3 7 0 1"});
    const OriginalBake bake = baked([&](std::uint32_t v) { return Rgb(float(v) + 1); });
    EXPECT_EQ(bake.unvalued, 2u * 3u);
    const BakedInstance& first = bake.instances[0];
    ASSERT_EQ(first.radiance.size(), 8u);
    for (const std::size_t v : {4u, 5u, 7u}) {
        EXPECT_EQ(first.radiance[v], Rgb(0.0f)) << v;
        EXPECT_EQ(first.mesh->normals[v], Vec3f(0, 1, 0)) << v;
    }
    EXPECT_EQ(first.mesh->positions[7], Vec3f(0, 0, 0));
    EXPECT_EQ(first.radiance[6], first.radiance[2]);
    EXPECT_NE(first.radiance[2], Rgb(0.0f));
    EXPECT_EQ(first.mesh->triangles.size(), 4u) << "two of the quad, and two without an area";
}

/// Returns the numbers in a row of a table, without the columns that are not compared.
std::vector<float> numbers_in(const std::string& line) {
    std::vector<float> numbers;
    std::istringstream cells(line);
    std::string cell;
    std::getline(cells, cell, ',');
    while (std::getline(cells, cell, ',')) numbers.push_back(std::stof(cell));
    return numbers;
}

TEST_F(OriginalVertices, AreWhatTheFilesHold) {
    Shape mirror;
    mirror.row[0].x = -1;
    for (const Shape& shape : {Shape(), mirror}) {
        prepare(cube_vertices, cube_faces, shape);
        const OriginalBake bake = baked([&](std::uint32_t v) { return by_normal(fine().normals[v]); });
        ASSERT_TRUE(write_baked_ply(folder / "a.ply", bake.instances));
        const Result<PolygonFile> ply = read_ply(text_of(folder / "a.ply"));
        ASSERT_TRUE(ply) << ply.error().message();
        ASSERT_EQ(ply->positions.size(), 16u);
        for (std::size_t v = 0; v < 16; ++v) {
            float x = 0, y = 0, z = 0;
            std::sscanf(cube_vertices[v % 8].c_str(), "%f %f %f", &x, &y, &z);
            EXPECT_EQ(ply->positions[v], Vec3f(shape == Shape() ? x : -x, y, z)) << v;
        }
        EXPECT_EQ(ply->face_corners, std::vector<std::uint32_t>(12, 4)) << "quads are preserved";
        const std::vector<std::uint32_t> corners(ply->corners.begin(), ply->corners.begin() + 4),
            second(ply->corners.begin() + 24, ply->corners.begin() + 28);
        EXPECT_EQ(corners, (shape == Shape() ? std::vector<std::uint32_t>{3, 2, 1, 0}
                                             : std::vector<std::uint32_t>{3, 0, 1, 2}));
        EXPECT_EQ(second[0], 11u);
        EXPECT_NE(text_of(folder / "a.ply").find("property int instance\nproperty int original_vertex\n"),
                  std::string::npos);

        ASSERT_TRUE(write_baked_csv(folder / "a.csv", bake.instances));
        std::istringstream table(text_of(folder / "a.csv"));
        std::string line;
        std::getline(table, line);
        for (std::size_t v = 0; v < 16; ++v) {
            ASSERT_TRUE(std::getline(table, line)) << v;
            const std::vector<float> numbers = numbers_in(line);
            EXPECT_EQ(numbers[0], float(v % 8));
            EXPECT_NEAR(numbers[7], 1 / 3.0, 1e-6);
        }
        EXPECT_FALSE(std::getline(table, line));

        ASSERT_TRUE(write_baked_glb(folder / "a.glb", bake.instances));
        const std::string glb = text_of(folder / "a.glb");
        EXPECT_NE(glb.find(R"("count":8,"type":"VEC3")"), std::string::npos);
        const Result<ModelFile> back = ModelFile::open(folder / "a.glb");
        ASSERT_TRUE(back) << back.error().message();
        const Result<ListedMesh> part = back->listed(0);
        ASSERT_TRUE(part);
        // assimp 5.4.3 lists the vertices of glTF files in the order of their first use, 5.2.5 as the file
        // does.
        if (aiGetVersionMajor() * 100 + aiGetVersionMinor() <= 502) {
            EXPECT_EQ(part->positions, bake.meshes[0].positions);
        }
        const std::vector<std::array<std::uint32_t, 3>>& triangles = bake.meshes[0].triangles;
        ASSERT_EQ(part->face_corners.size(), 12u);
        ASSERT_EQ(triangles.size(), 12u);
        for (std::size_t i = 0; i < 36; ++i)
            EXPECT_EQ(part->positions[part->corners[i]], bake.meshes[0].positions[triangles[i / 3][i % 3]])
                << i;
    }
}

/// A disc of 300 corners, more than fit in a byte.
TEST_F(OriginalVertices, OfLargePolygonsKeepTheirFaces) {
    std::vector<std::string> vertices;
    std::string face = "300";
    for (int i = 0; i < 300; ++i) {
        vertices.push_back(fmt::format("{} 0 {}", std::cos(2 * pi * i / 300), -std::sin(2 * pi * i / 300)));
        face += fmt::format(" {}", i);
    }
    prepare(vertices, {face});
    const OriginalBake bake = baked([](std::uint32_t) { return Rgb(1.0f); });
    ASSERT_TRUE(write_baked_ply(folder / "a.ply", bake.instances));
    const Result<PolygonFile> ply = read_ply(text_of(folder / "a.ply"));
    ASSERT_TRUE(ply) << ply.error().message();
    EXPECT_EQ(ply->face_corners, (std::vector<std::uint32_t>{300, 300}));
    EXPECT_EQ(ply->corners[300 + 7], 307u);
}

/// Two adjacent squares, the left one with an image. At the edge between the halves of the left one, the
/// texture coordinates differ.
class TexturedOriginalVertices : public testing::Test {
protected:
    void SetUp() override {
        write_png(texture, folder / "a.png");
        write_text(folder / "a.mtl", "newmtl image\nKd 1 1 1\nmap_Kd a.png\nnewmtl plain\nKd 0.5 0.5 0.5\n");
        std::string text = "mtllib a.mtl\n";
        for (const char* z : {"0", "1"})
            for (const char* x : {"0", "1", "2"}) text += fmt::format("v {} 0 {}\n", x, z);
        for (const auto& [u, v] : uvs) text += fmt::format("vt {} {}\n", u, v);
        text += "usemtl image\nf 4/4 5/3 2/2\nf 4/5 2/6 1/1\nusemtl plain\nf 5 6 3 2\n";
        write_text(folder / "a.obj", text);
        Scene scene;
        scene.entities.emplace_back();
        scene.entities[0].name = "a";
        scene.entities[0].mesh = folder / "a.obj";
        scene.instances.push_back({"first", 0, {}, {}});
        prepare_with_original_vertices(scene, entities);
    }

    const TestFolder folder;
    const Texture texture = random_texture(8, 8);
    const std::vector<std::pair<float, float>> uvs{{0.1f, 0.1f}, {0.4f, 0.1f}, {0.4f, 0.4f},
                                                   {0.1f, 0.4f}, {0.6f, 0.9f}, {0.9f, 0.6f}};
    SceneEntities entities;
};

TEST_F(TexturedOriginalVertices, SeparateLightFromImagesInFilesWithImages) {
    const SceneEntity& entity = *entities.entities[0];
    const Mesh& fine = entity.mesh.fine;
    std::vector<Rgb> light;
    for (const Vec3f& p : fine.positions) light.emplace_back(1 + p.x, 2.0f, 1 + p.z);
    const std::vector<BakedInstance> instances{{"first", &fine, {}, light, {}, entity.surfaces}};
    const OriginalBake bake = original_bake(entities, instances, true);
    ASSERT_EQ(bake.instances[0].mesh->positions.size(), 6u);
    ASSERT_EQ(bake.textured.size(), 1u);
    const BakedInstance& textured = bake.textured[0];
    const Mesh& mesh = *textured.mesh;
    ASSERT_EQ(mesh.uvs.size(), mesh.positions.size());
    ASSERT_TRUE(
        std::equal(bake.meshes[0].positions.begin(), bake.meshes[0].positions.end(), mesh.positions.begin()))
        << "the file's vertices are first";
    EXPECT_EQ(mesh.positions.size(), 10u) << "two more at the seam, and two at the edge between materials";
    EXPECT_EQ(mesh.triangles.size(), 4u);
    std::multiset<std::pair<float, float>> found;
    for (const auto& triangle : mesh.triangles)
        for (const std::uint32_t v : triangle) {
            const Vec3f& p = mesh.positions[v];
            EXPECT_EQ(mesh.original_vertices[v], std::int32_t(p.x) + 3 * std::int32_t(p.z));
            EXPECT_EQ(mesh.vertex_materials[v], mesh.vertex_materials[triangle[0]]);
            EXPECT_EQ(textured.radiance[v], Rgb(1 + p.x, 2.0f, 1 + p.z)) << "light alone";
            if (textured.surfaces[mesh.vertex_materials[v]].texture)
                found.emplace(mesh.uvs[v].x, mesh.uvs[v].y);
        }
    EXPECT_EQ(found, (std::multiset<std::pair<float, float>>(uvs.begin(), uvs.end())));

    const OriginalBake plain = original_bake(entities, instances, false);
    EXPECT_TRUE(plain.textured.empty() && plain.textured_meshes.empty());
    EXPECT_EQ(plain.values.size(), 1u) << "no light for files with images";
    EXPECT_TRUE(std::ranges::equal(plain.instances[0].radiance, bake.instances[0].radiance));

    ASSERT_TRUE(write_baked_glb(folder / "a.glb", bake.textured));
    const Result<ModelFile> back = ModelFile::open(folder / "a.glb");
    ASSERT_TRUE(back) << back.error().message();
    const std::string glb = text_of(folder / "a.glb");
    EXPECT_NE(glb.find("TEXCOORD_0"), std::string::npos);
    EXPECT_NE(glb.find(text_of(folder / "a.png")), std::string::npos);
}

}  // namespace
}  // namespace haarfield
