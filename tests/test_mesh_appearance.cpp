/// Materials, images, texture coordinates and colours, from the file to the baked mesh.

#include <gtest/gtest.h>

#include "fields/base/srgb.h"
#include "fields/mesh/mesh_subdivision.h"
#include "fields/mesh/shared_vertices.h"
#include "fields/model/mesh_reader.h"
#include "fields/model/model_file.h"
#include "fields/occluder/occluder.h"
#include "fields/preparation/mesh_preparation.h"
#include "scenes/scene_entities.h"
#include "tests/fixtures/example_textures.h"

namespace haarfield {
namespace {

constexpr MeshReaderOptions with_appearance{.appearance = true};

/// Four squares in a row. Two share an image, with a seam between them; one of the others has no image.
constexpr const char* squares_obj =
    "mtllib squares.mtl\n"
    "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 3 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\nv 3 1 0\n"
    "vt 0 0\nvt 0.5 0\nvt 0.5 1\nvt 0 1\nvt 0.7 0.2\nvt 1 0.2\nvt 1 0.9\nvt 0.7 0.9\n"
    "usemtl wood\nf 1/1 2/2 6/3 5/4\nf 2/5 3/6 7/7 6/8\n"
    "usemtl steel\nf 3/1 4/2 8/3 7/4\n";

constexpr const char* squares_mtl =
    "newmtl wood\nKd 0.5 0.25 0.125\nKs 0.3 0.3 0.3\nNs 60\nd 1\nillum 2\nmap_Kd wood.png\nmap_Bump "
    "bumps.png\n"
    "newmtl steel\nKd 0 0 0.5\nKs 0.9 0.9 0.9\nNs 10\nillum 1\nKe 0 2 0\n"
    "newmtl unused\nKd 1 1 1\n";

class MeshAppearance : public testing::Test {
protected:
    std::filesystem::path written(const std::string& name, std::string_view text) {
        write_text(folder / name, text);
        return folder / name;
    }
    ImportedMesh squares() {
        written("squares.mtl", squares_mtl);
        write_png(random_texture(4, 4), folder / "wood.png");
        return *read_mesh(written("squares.obj", squares_obj), with_appearance);
    }

    const TestFolder folder;
};

TEST_F(MeshAppearance, MtlSaysKdKsNsAndImages) {
    const ImportedMesh read = squares();
    ASSERT_EQ(read.mesh.material_names, (std::vector<std::string>{"wood", "steel"}));
    ASSERT_EQ(read.materials.size(), 2u);
    const MeshMaterial &wood = read.materials[0], &steel = read.materials[1];
    EXPECT_EQ(wood.model, MeshMaterial::Model::phong);
    EXPECT_EQ(wood.diffuse, Rgb(0.5f, 0.25f, 0.125f));
    EXPECT_EQ(wood.specular, Rgb(0.3f));
    EXPECT_EQ(wood.exponent, 60);
    EXPECT_EQ(wood.image.name, "wood.png");
    EXPECT_EQ(wood.image.file, folder / "wood.png");
    EXPECT_EQ(steel.specular, Rgb(0.0f)) << "illum 1 has no specular term";
    EXPECT_EQ(steel.emission, Rgb(0, 2, 0));
    EXPECT_FALSE(steel.image.is_there());
    EXPECT_EQ(read.unused, (std::map<std::string, std::size_t>{{"bump map", 1}}));
    EXPECT_EQ(ModelFile::open(folder / "squares.obj")->unused(), (UnusedProperties{{"bump map", {"wood"}}}));
    EXPECT_EQ(read.mapped, (std::vector<bool>{true, true}));
    EXPECT_EQ(read.coloured, (std::vector<bool>{false, false}));
}

TEST_F(MeshAppearance, VerticesAreSplitAtSeamsOfTheImage) {
    const ImportedMesh read = squares();
    EXPECT_EQ(read.mesh.positions.size(), 12u);
    const Mesh image_only = with_shared_vertices(read.mesh, {{true, false}, {false, false}});
    EXPECT_EQ(image_only.positions.size(), 12u);
    ASSERT_EQ(image_only.uvs.size(), 12u);
    for (std::size_t v = 0; v < 12; ++v) {
        const Vec3f& p = image_only.positions[v];
        if (image_only.vertex_materials[v] == 1) {
            EXPECT_EQ(image_only.uvs[v], Vec2f(0, 0));
        }
        if (p.x == 0) {
            EXPECT_EQ(image_only.uvs[v], Vec2f(0, p.y));
        }
    }
    // Without appearance, the result is that of a file without it.
    const Mesh plain = with_shared_vertices(read.mesh, {{false, false}, {false, false}});
    const Mesh never = read_mesh(folder / "squares.obj")->mesh;
    EXPECT_TRUE(plain.uvs.empty());
    EXPECT_EQ(plain.positions, never.positions);
    EXPECT_EQ(plain.triangles, never.triangles);
    EXPECT_EQ(plain.vertex_materials, never.vertex_materials);
    EXPECT_LT(plain.positions.size(), 12u);
}

/// In each square of the file, a vertex's position in a finer mesh determines its position in the image.
TEST_F(MeshAppearance, TexturesStayInPlaceOnTheWayToTheFineMesh) {
    ImportedMesh read = squares();
    read.mesh = with_shared_vertices(read.mesh, {{true, false}, {false, false}});
    const PreparedMesh prepared = *prepare_mesh(std::move(read), {500, 0});
    const Mesh& fine = prepared.fine;
    ASSERT_EQ(fine.uvs.size(), fine.positions.size());
    ASSERT_GE(fine.positions.size(), 500u);
    bool has_back = false;
    for (const auto& triangle : fine.triangles)
        for (const std::uint32_t v : triangle) {
            if (fine.vertex_materials[v] != 0) continue;
            const Vec3f middle =
                (fine.positions[triangle[0]] + fine.positions[triangle[1]] + fine.positions[triangle[2]]) /
                3.0f;
            const Vec3f& p = fine.positions[v];
            const Vec2f expected =
                middle.x < 1 ? Vec2f(p.x / 2, p.y) : Vec2f(0.7f + 0.3f * (p.x - 1), 0.2f + 0.7f * p.y);
            ASSERT_NEAR(fine.uvs[v].x, expected.x, 1e-3);
            ASSERT_NEAR(fine.uvs[v].y, expected.y, 1e-3);
            has_back |= fine.normals[v].z < 0;
        }
    EXPECT_TRUE(has_back);
}

TEST_F(MeshAppearance, ImagesAreReadOnlyFromTheDirectoryOfTheFile) {
    std::filesystem::create_directories(folder / "models/textures");
    write_png(random_texture(2, 2), folder / "outside.png");
    write_png(random_texture(2, 2), folder / "models/textures/below.png");
    write_png(random_texture(2, 2), folder / "models/beside.png");
    const auto image_of = [&](const std::string& name) {
        write_text(folder / "models/squares.mtl",
                   "newmtl wood\nKd 1 1 1\nmap_Kd " + name + "\nnewmtl steel\n");
        return read_mesh(written("models/squares.obj", squares_obj), with_appearance)->materials[0].image;
    };
    EXPECT_EQ(image_of("textures/below.png").file, folder / "models/textures/below.png");
    EXPECT_EQ(image_of("textures\\below.png").file, folder / "models/textures/below.png");
    EXPECT_EQ(image_of("/home/someone/beside.png").file, folder / "models/beside.png");
    EXPECT_EQ(image_of("C:\\Users\\beside.png").file, folder / "models/beside.png");
    EXPECT_FALSE(image_of("../outside.png").is_there());
    EXPECT_FALSE(image_of("textures/../../outside.png").is_there());
    EXPECT_FALSE(image_of((folder / "outside.png").string()).is_there());
    EXPECT_FALSE(image_of("none.png").is_there());
}

std::string base64(const std::string& bytes) {
    static const char* const digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        unsigned group = 0;
        for (std::size_t k = 0; k < 3; ++k)
            group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
        for (std::size_t k = 0; k < 4; ++k)
            text += i + k > bytes.size() ? '=' : digits[group >> (18 - 6 * k) & 63];
    }
    return text;
}

template <class T>
std::string bytes_of(const std::vector<T>& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

/// Returns a triangle with vertex colours and an embedded image.
std::string triangle_gltf(const std::string& material, const std::string& image) {
    const std::string positions = bytes_of<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}),
                      uvs = bytes_of<float>({0.1f, 0.2f, 0.9f, 0.3f, 0.4f, 0.8f}),
                      colours = bytes_of<float>({1, 1, 1, 0.5f, 0.25f, 1, 0, 0, 0.75f});
    const std::string data = positions + uvs + colours;
    return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1,"COLOR_0":2},"material":0}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
{"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"},{"bufferView":2,"componentType":5126,"count":3,"type":"VEC3"}],
"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":24},
{"buffer":0,"byteOffset":60,"byteLength":36}],
"images":[{"uri":"data:image/png;base64,)" +
           base64(image) + R"("}],"samplers":[{}],"textures":[{"source":0,"sampler":0}],
"extensionsUsed":["KHR_texture_transform"],"materials":[)" +
           material + R"(],"buffers":[{"byteLength":)" + std::to_string(data.size()) +
           R"(,"uri":"data:application/octet-stream;base64,)" + base64(data) + "\"}]}";
}

TEST_F(MeshAppearance, AMaterialWithAnEmissionMapEmitsNoLight) {
    const std::string png = *png_bytes(random_texture(3, 2).texels, 3, 2, false);
    const ImportedMesh gltf =
        *read_mesh(written("lit.gltf", triangle_gltf(R"({"name":"lantern","emissiveFactor":[1,1,1],
"emissiveTexture":{"index":0},"pbrMetallicRoughness":{}})",
                                                     png)),
                   with_appearance);
    EXPECT_EQ(gltf.materials[0].emission, Rgb(0.0f));
    ASSERT_EQ(gltf.unused.size(), 1u);
    EXPECT_TRUE(gltf.unused.begin()->first.starts_with("emission map")) << gltf.unused.begin()->first;
    EXPECT_EQ(ModelFile::open(folder / "lit.gltf")->unused().begin()->second,
              std::set<std::string>{"lantern"});

    written("lit.mtl",
            "newmtl wood\nKd 0.5 0.5 0.5\nKe 1 1 1\nmap_Ke lit.png\nnewmtl steel\nKd 1 1 1\nKe 0 2 0\n");
    std::string text = squares_obj;
    text.replace(0, text.find('\n'), "mtllib lit.mtl");
    const ImportedMesh obj = *read_mesh(written("lit.obj", text), with_appearance);
    ASSERT_EQ(obj.materials.size(), 2u);
    EXPECT_EQ(obj.materials[0].emission, Rgb(0.0f));
    EXPECT_EQ(obj.materials[1].emission, Rgb(0, 2, 0)) << "has no map";
    ASSERT_EQ(obj.unused.size(), 1u);
    EXPECT_EQ(ModelFile::open(folder / "lit.obj")->unused().begin()->second, std::set<std::string>{"wood"});
}

TEST_F(MeshAppearance, GltfSaysMetalRoughnessImagesAndColours) {
    const Texture texture = random_texture(3, 2);
    const std::string png = *png_bytes(texture.texels, 3, 2, false);
    const ImportedMesh read =
        *read_mesh(written("a.gltf", triangle_gltf(R"({"name":"brass","alphaMode":"MASK","alphaCutoff":0.25,
"emissiveFactor":[0,0.5,1],"normalTexture":{"index":0},"pbrMetallicRoughness":{"baseColorFactor":[0.75,0.5,0.25,1],
"metallicFactor":0.5,"roughnessFactor":0.125,"baseColorTexture":{"index":0}}})",
                                                   png)),
                   with_appearance);
    ASSERT_EQ(read.materials.size(), 1u);
    const MeshMaterial& brass = read.materials[0];
    EXPECT_EQ(read.mesh.material_names[0], "brass");
    EXPECT_EQ(brass.model, MeshMaterial::Model::metallic);
    EXPECT_EQ(brass.diffuse, Rgb(0.75f, 0.5f, 0.25f));
    EXPECT_EQ(brass.metallic, 0.5f);
    EXPECT_EQ(brass.roughness, 0.125f);
    EXPECT_EQ(brass.emission, Rgb(0, 0.5f, 1));
    EXPECT_EQ(brass.alpha, AlphaMode::mask);
    EXPECT_EQ(brass.alpha_cutoff, 0.25f);
    ASSERT_TRUE(brass.image.bytes);
    EXPECT_EQ(*brass.image.bytes, png);
    EXPECT_EQ(read.unused, (std::map<std::string, std::size_t>{{"normal map", 1}}));
    EXPECT_EQ(read.coloured, (std::vector<bool>{true}));
    ASSERT_EQ(read.mesh.positions.size(), 3u);
    for (std::size_t v = 0; v < 3; ++v) {
        const Vec3f& p = read.mesh.positions[v];
        const Rgb expected = p.x == 1 ? Rgb(0.5f, 0.25f, 1) : p.y == 1 ? Rgb(0, 0, 0.75f) : Rgb(1.0f);
        EXPECT_EQ(read.mesh.colours[v], expected);  // linear in the file
        const Vec2f uv = p.x == 1 ? Vec2f(0.9f, 0.7f) : p.y == 1 ? Vec2f(0.4f, 0.2f) : Vec2f(0.1f, 0.8f);
        EXPECT_NEAR(read.mesh.uvs[v].x, uv.x, 1e-6);
        EXPECT_NEAR(read.mesh.uvs[v].y, uv.y, 1e-6);  // v is measured from the top in glTF
    }
}

/// The extension's formula: offset + rotation * scale * uv, from the upper left corner.
TEST_F(MeshAppearance, GltfTexturesAreTransformed) {
    const Texture texture = random_texture(2, 2);
    const std::string png = *png_bytes(texture.texels, 2, 2, false);
    const ImportedMesh read = *read_mesh(
        written("a.gltf",
                triangle_gltf(R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0,"extensions":
{"KHR_texture_transform":{"offset":[0.3,-0.2],"rotation":0.7,"scale":[2,0.5]}}}}})",
                              png)),
        with_appearance);
    const double c = std::cos(0.7), s = std::sin(0.7);
    for (std::size_t v = 0; v < 3; ++v) {
        const Vec3f& p = read.mesh.positions[v];
        const Vec2f uv = p.x == 1 ? Vec2f(0.9f, 0.3f) : p.y == 1 ? Vec2f(0.4f, 0.8f) : Vec2f(0.1f, 0.2f);
        const double u = 2 * double(uv.x), w = 0.5 * double(uv.y);
        EXPECT_NEAR(double(read.mesh.uvs[v].x), c * u + s * w + 0.3, 1e-5);
        EXPECT_NEAR(double(read.mesh.uvs[v].y), 1 - (c * w - s * u - 0.2), 1e-5);
    }
}

TEST_F(MeshAppearance, AMediaTypeWithoutASlashIsRefused) {
    std::string text = triangle_gltf("{}", *png_bytes(random_texture(1, 1).texels, 1, 1, false));
    text.replace(text.find("data:image/png"), 14, "data:image_png");
    const Result<ImportedMesh> read = read_mesh(written("a.gltf", text));
    ASSERT_FALSE(read);
    EXPECT_NE(read.error().message().find("media type"), std::string::npos) << read.error().message();
}

/// An extent that is the smallest float.
TEST_F(MeshAppearance, SurfacesAsThinAsAFloatCanBeArePrepared) {
    Result<ImportedMesh> read = read_mesh(written("a.obj", "v 0 0 1e-39\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
    ASSERT_TRUE(read) << read.error().message();
    const Result<PreparedMesh> prepared = prepare_mesh(*std::move(read), {50, 10});
    ASSERT_TRUE(prepared) << prepared.error().message();
    const Occluder occluder = make_occluder(prepared->coarse);
    EXPECT_FALSE(InsideTest(occluder)({0.2f, 0.2f, 0.5f}));
}

TEST_F(MeshAppearance, PlyColoursAreLinear) {
    const std::string head =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
    const std::string faces = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    const ImportedMesh bytes = *read_mesh(
        written("a.ply", head + "property uchar red\nproperty uchar green\nproperty uchar blue\n" + faces +
                             "0 0 0 255 128 0\n1 0 0 255 128 0\n0 1 0 255 128 0\n3 0 1 2\n"),
        with_appearance);
    EXPECT_EQ(bytes.materials[0].model, MeshMaterial::Model::by_colour);
    EXPECT_EQ(bytes.coloured, (std::vector<bool>{true}));
    EXPECT_NEAR(bytes.mesh.colours[0].y, srgb_decoded(128 / 255.0f), 1e-6);
    const ImportedMesh floats =
        *read_mesh(written("b.ply", head + "property float red\nproperty float green\nproperty float blue\n" +
                                        faces + "0 0 0 1 0.5 0\n1 0 0 1 0.5 0\n0 1 0 1 0.5 0\n3 0 1 2\n"),
                   with_appearance);
    EXPECT_EQ(floats.mesh.colours[0], Rgb(1, 0.5f, 0));
    EXPECT_TRUE(read_mesh(folder / "b.ply")->mesh.colours.empty());
}

TEST_F(MeshAppearance, ScenesUseTheFilesMaterialsAndReplaceThemByName) {
    squares();
    Scene scene;
    Entity entity;
    entity.name = "squares";
    entity.mesh = folder / "squares.obj";
    entity.fine_vertices = 50;
    scene.entities = {entity};
    scene.instances = {{"squares", 0, {}}};
    SceneEntityOptions options;
    options.fields = FieldExtent::none;
    const auto surfaces = [&] {
        const Result<SceneEntities> made = prepare_scene_entities(scene, options);
        EXPECT_TRUE(made) << made.error().message();
        return made->entities[0]->surfaces;
    };
    const auto own = surfaces();
    ASSERT_EQ(own.size(), 2u);
    ASSERT_TRUE(own[0].texture);
    EXPECT_EQ(own[0].texture->texels, random_texture(4, 4).texels);
    EXPECT_EQ(own[0].material.diffuse, Rgb(0.5f, 0.25f, 0.125f));
    EXPECT_FALSE(own[1].texture);
    EXPECT_EQ(own[1].emission, Rgb(0, 2, 0));

    scene.materials["paint"].diffuse = Rgb(0.9f);
    scene.materials["paint"].image = folder / "wood.png";
    scene.entities[0].materials = {{"steel", "paint"}};
    const auto mixed = surfaces();
    EXPECT_TRUE(mixed[0].texture);
    ASSERT_TRUE(mixed[1].texture);
    EXPECT_EQ(mixed[1].material.diffuse, Rgb(0.9f));
    EXPECT_EQ(mixed[1].emission, Rgb(0.0f));

    scene.entities[0].materials = {{"stel", "paint"}};
    const Result<SceneEntities> wrong = prepare_scene_entities(scene, options);
    ASSERT_FALSE(wrong);
    EXPECT_NE(wrong.error().message().find("no material \"stel\""), std::string::npos)
        << wrong.error().message();
    EXPECT_NE(wrong.error().message().find("\"wood\", \"steel\""), std::string::npos);
}

}  // namespace
}  // namespace haarfield
