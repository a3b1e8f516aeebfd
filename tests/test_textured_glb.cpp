#include "bridge/files/glb_file.h"
#include "fields/model/mesh_reader.h"
#include "fields/model/model_file.h"
#include "tests/fixtures/bridge_fixtures.h"
#include "tests/fixtures/example_textures.h"

#include <nlohmann/json.hpp>

#include <cstring>
#include <map>

namespace haarfield {
namespace {

nlohmann::json json_of(const std::string& glb) {
    std::uint32_t length = 0;
    std::memcpy(&length, &glb.at(12), 4);
    return nlohmann::json::parse(glb.substr(20, length));
}

std::string image_bytes(const std::string& glb, const nlohmann::json& scene, std::size_t image) {
    std::uint32_t length = 0;
    std::memcpy(&length, &glb.at(12), 4);
    const nlohmann::json& view =
        scene["bufferViews"][scene["images"][image]["bufferView"].get<std::size_t>()];
    EXPECT_EQ(view["byteOffset"].get<std::size_t>() % 4, 0u);
    return glb.substr(28 + length + view["byteOffset"].get<std::size_t>(), view["byteLength"]);
}

/// Returns a square whose triangles alternate between three materials, two of which have an image.
Mesh striped_square() {
    const Mesh square = upright_square_mesh(1, 4);
    Mesh mesh;
    mesh.material_names = {"wood", "plain", "leaf"};
    for (std::size_t t = 0; t < square.triangles.size(); ++t) {
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        for (const std::uint32_t corner : square.triangles[t]) {
            const Vec3f& p = square.positions[corner];
            mesh.positions.push_back(p);
            mesh.normals.push_back(square.normals[corner]);
            mesh.vertex_materials.push_back(static_cast<std::uint16_t>(t % 3));
            mesh.uvs.emplace_back(p.x + 0.3f, 1.5f * p.y - 0.2f);
        }
        mesh.triangles.push_back({first, first + 1, first + 2});
    }
    return mesh;
}

class TexturedGlb : public testing::Test {
protected:
    TexturedGlb() {
        for (std::size_t v = 0; v < mesh.positions.size(); ++v)
            light.push_back(Rgb(0.3f + 0.2f * mesh.positions[v].x, 0.5f, 0.4f + 0.3f * mesh.positions[v].y));
    }

    /// Returns the texture of an image file, read like that of a model.
    std::shared_ptr<const Texture> texture(const std::string& name, AlphaMode alpha) {
        Result<Texture> read = read_texture({{name, folder / name, nullptr}, {}, alpha, 0.5f});
        EXPECT_TRUE(read) << read.error().message();
        return std::make_shared<const Texture>(*std::move(read));
    }

    const TestFolder folder;
    const Mesh mesh = striped_square();
    std::vector<Rgb> light;
    std::vector<Surface> surfaces{3};
};

TEST_F(TexturedGlb, HoldsTheBytesOfImagesAndWhatTheyMultiply) {
    write_png(random_texture(9, 7), folder / "wood.png");
    write_png(random_texture(6, 6, true), folder / "leaf.png");
    surfaces[0].texture = texture("wood.png", AlphaMode::opaque);
    surfaces[2].texture = texture("leaf.png", AlphaMode::blend);
    const std::vector<BakedInstance> instances{{"a", &mesh, {}, light, {}, surfaces},
                                               {"b", &mesh, {{2, 0, 0}, 3}, light, {}, surfaces}};
    ASSERT_TRUE(write_baked_glb(folder / "a.glb", instances));
    const std::string glb = text_of(folder / "a.glb");
    const nlohmann::json scene = json_of(glb);
    ASSERT_EQ(scene["images"].size(), 2u);
    EXPECT_EQ(image_bytes(glb, scene, 0), text_of(folder / "wood.png"));
    EXPECT_EQ(image_bytes(glb, scene, 1), text_of(folder / "leaf.png"));
    EXPECT_EQ(scene["images"][0]["mimeType"], "image/png");
    ASSERT_EQ(scene["materials"].size(), 3u);
    for (const nlohmann::json& material : scene["materials"])
        EXPECT_TRUE(material["extensions"].contains("KHR_materials_unlit"));
    EXPECT_FALSE(scene["materials"][0]["pbrMetallicRoughness"].contains("baseColorTexture"));
    EXPECT_FALSE(scene["materials"][1].contains("alphaMode"));
    EXPECT_EQ(scene["materials"][2]["alphaMode"], "MASK") << "opacity is 0 or 1";
    ASSERT_EQ(scene["meshes"][1]["primitives"].size(), 3u);
    for (std::size_t p = 0; p < 3; ++p) {
        const nlohmann::json &first = scene["meshes"][0]["primitives"][p],
                             &second = scene["meshes"][1]["primitives"][p];
        EXPECT_EQ(first["indices"], second["indices"]) << "shared";
        EXPECT_EQ(first["attributes"]["TEXCOORD_0"], second["attributes"]["TEXCOORD_0"]);
        EXPECT_NE(first["attributes"]["COLOR_0"], first["attributes"]["_RADIANCE"]);
    }

    // As a third-party reader interprets it: the visible colour is the image times the vertex colour.
    const Result<ModelFile> model = ModelFile::open(folder / "a.glb");
    ASSERT_TRUE(model) << model.error().message();
    const Result<ImportedMesh> back = read_mesh(*model, 0, {.appearance = true});
    ASSERT_TRUE(back) << back.error().message();
    ASSERT_EQ(back->materials.size(), 3u);
    ASSERT_EQ(back->mesh.triangles.size(), mesh.triangles.size());
    std::map<std::string, std::size_t> triangles;
    std::size_t compared = 0;
    for (const auto& triangle : back->mesh.triangles) {
        const std::size_t material = back->mesh.vertex_materials[triangle[0]];
        const MeshImage& image = back->materials[material].image;
        std::optional<Texture> shown;
        if (image.is_there()) shown = *read_texture({image, {}, AlphaMode::opaque, 0.5f});
        for (const std::uint32_t corner : triangle) {
            const Vec3f& p = back->mesh.positions[corner];
            const Rgb seen =
                back->mesh.colours[corner] * (shown ? shown->colour_at(back->mesh.uvs[corner]) : Rgb(1.0f));
            for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
                const Texture* own = surfaces[mesh.vertex_materials[v]].texture.get();
                if (mesh.positions[v] != p || bool(own) != bool(shown) || (own && own->width != shown->width))
                    continue;
                for (int c = 0; c < 3; ++c)
                    EXPECT_NEAR(seen[c], displayed_radiance(instances[0], v)[c], 2e-5f) << v;
                ++compared;
            }
        }
        ++triangles[back->materials[material].image.name];
    }
    EXPECT_EQ(triangles.size(), 3u);
    EXPECT_GE(compared, mesh.positions.size());
}

TEST_F(TexturedGlb, WritesAnewWhatIsNoFilesOwnImage) {
    Texture jpeg = random_texture(4, 4);
    jpeg.jpeg = "\xff\xd8\xff as it was";
    Texture soft = random_texture(5, 3, true);
    soft.texels[1][3] = 100;
    soft.png.clear();
    surfaces[0].texture = std::make_shared<const Texture>(jpeg);
    surfaces[2].texture = std::make_shared<const Texture>(soft);
    const BakedInstance instance{"a", &mesh, {}, light, {}, surfaces};
    ASSERT_TRUE(write_baked_glb(folder / "a.glb", {&instance, 1}));
    const std::string glb = text_of(folder / "a.glb");
    const nlohmann::json scene = json_of(glb);
    EXPECT_EQ(image_bytes(glb, scene, 0), jpeg.jpeg);
    EXPECT_EQ(scene["images"][0]["mimeType"], "image/jpeg");
    EXPECT_EQ(image_bytes(glb, scene, 1), *png_bytes(soft.texels, 5, 3, true));
    EXPECT_EQ(scene["materials"][2]["alphaMode"], "BLEND");
}

/// Alpha that was thresholded differs from the file's.
TEST_F(TexturedGlb, ChangedImagesHaveNoFileBytes) {
    Texture soft = random_texture(6, 6, true);
    for (std::size_t i = 0; i < soft.texels.size(); ++i) soft.texels[i][3] = std::uint8_t(7 * i);
    write_png(soft, folder / "soft.png");
    EXPECT_EQ(texture("soft.png", AlphaMode::blend)->png, text_of(folder / "soft.png"));
    EXPECT_EQ(texture("soft.png", AlphaMode::opaque)->png, text_of(folder / "soft.png"));
    EXPECT_EQ(texture("soft.png", AlphaMode::mask)->png, "");
    EXPECT_TRUE(texture("soft.png", AlphaMode::mask)->has_alpha);
}

/// The specular term is part of the factor of the image, so that the mean is preserved.
TEST_F(TexturedGlb, SpecularLightKeepsItsStrengthOnUniformImages) {
    Texture grey = random_texture(4, 4);
    for (auto& texel : grey.texels) texel = {188, 100, 10, 255};  // 0.5, 0.127 and 0.003
    surfaces[0].texture = std::make_shared<const Texture>(grey);
    const std::vector<Rgb> over(mesh.positions.size(), Rgb(0.05f));
    const BakedInstance instance{"a", &mesh, {}, light, over, surfaces};
    ASSERT_TRUE(write_baked_glb(folder / "a.glb", {&instance, 1}));
    const Result<ModelFile> model = ModelFile::open(folder / "a.glb");
    ASSERT_TRUE(model);
    const Result<ImportedMesh> back = read_mesh(*model, {}, {.appearance = true});
    ASSERT_TRUE(back);
    const Rgb shown = grey.colour_at({0, 0});
    std::size_t checked = 0;
    for (std::size_t v = 0; v < back->mesh.positions.size(); ++v) {
        if (!back->materials[back->mesh.vertex_materials[v]].image.is_there()) continue;
        const Vec3f& p = back->mesh.positions[v];
        const Rgb under(0.3f + 0.2f * p.x, 0.5f, 0.4f + 0.3f * p.y);
        const Rgb seen = back->mesh.colours[v] * shown;
        EXPECT_NEAR(seen.x, under.x * shown.x + 0.05f, 1e-4f);
        EXPECT_NEAR(seen.y, under.y * shown.y + 0.05f, 1e-4f);
        EXPECT_LT(seen.z, 0.02f) << "at most a twenty-fifth of the specular term is added to black";
        ++checked;
    }
    EXPECT_GT(checked, 20u);
}

}  // namespace
}  // namespace haarfield
