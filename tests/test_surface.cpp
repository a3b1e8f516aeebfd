#include "scenes/surface.h"

#include <gtest/gtest.h>

#include "tests/fixtures/example_meshes.h"
#include "tests/fixtures/example_textures.h"

namespace haarfield {
namespace {

TEST(Surface, ConvertsPhongToPovraysSpecular) {
    MeshMaterial file;
    file.model = MeshMaterial::Model::phong;
    file.diffuse = Rgb(0.1f, 0.2f, 0.3f);
    file.specular = Rgb(0.5f);
    file.exponent = 80;
    const Surface surface = surface_of(file);
    EXPECT_EQ(surface.material.convention, LobeConvention::povray);
    EXPECT_EQ(surface.material.diffuse, file.diffuse);
    EXPECT_EQ(surface.material.specular, Rgb(0.5f));
    EXPECT_EQ(surface.material.phong, 0);
    EXPECT_EQ(surface.material.blinn, 1);
    EXPECT_FLOAT_EQ(surface.material.roughness, 1 / 80.0f);
    EXPECT_EQ(surface.tinted_specular, 0);
    EXPECT_TRUE(surface.is_plain());
}

/// A specular lobe's energy under uniform light, viewed along the normal. POV-Ray's lobe has no cosine, so
/// its albedo is weight * 2 / (n + 1).
TEST(Surface, MetalsReflectTheirBaseColour) {
    MeshMaterial file;
    file.model = MeshMaterial::Model::metallic;
    file.diffuse = Rgb(0.9f, 0.6f, 0.3f);
    file.metallic = 1;
    file.roughness = 0.3f;
    const Surface metal = surface_of(file);
    EXPECT_EQ(metal.material.diffuse, Rgb(0.0f));
    EXPECT_EQ(metal.tinted_specular, 1);
    const double n = double(metal.material.shininess);
    EXPECT_NEAR(n, (2 / std::pow(0.3, 4) - 2) / 4, 0.01);
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(double(metal.material.specular[c]) * double(metal.material.phong) * 2 / (n + 1),
                    double(file.diffuse[c]), 0.02);

    file.metallic = 0;
    const Surface plastic = surface_of(file);
    EXPECT_EQ(plastic.material.diffuse, file.diffuse);
    EXPECT_FLOAT_EQ(plastic.material.specular.x, 0.04f);
    EXPECT_EQ(plastic.tinted_specular, 0);
    file.roughness = 1;  // hardly any specular reflection
    EXPECT_EQ(surface_of(file).material.specular, Rgb(0.0f));
}

TEST(Surface, UnspecifiedMaterialsHaveTheDefaults) {
    EXPECT_EQ(surface_of({}).material.diffuse, Material().diffuse);
    MeshMaterial coloured;
    coloured.model = MeshMaterial::Model::by_colour;
    coloured.diffuse = Rgb(1.0f);
    EXPECT_EQ(surface_of(coloured).material.diffuse, Rgb(1.0f));
}

TEST(Surface, LayeredRadianceIsSplitWhereTexturesAre) {
    Mesh mesh = square_mesh(1, 0, 1);
    mesh.material_names = {"plain", "image", "metal", "coloured"};
    ASSERT_EQ(mesh.positions.size(), 4u);
    mesh.vertex_materials = {0, 1, 2, 3};
    mesh.uvs.assign(4, Vec2f(0, 0));
    mesh.colours.assign(4, Rgb(0.5f, 1, 0.25f));
    std::vector<Surface> surfaces(4);
    for (Surface& surface : surfaces) surface.material.specular = Rgb(0.1f);
    const auto texture = std::make_shared<const Texture>(random_texture(2, 2));
    surfaces[1].texture = surfaces[2].texture = texture;
    surfaces[1].emission = Rgb(0.25f);
    surfaces[2].tinted_specular = 0.75f;
    surfaces[3].coloured = true;
    const std::vector<Outgoing> radiance(4, {Rgb(1.5f), Rgb(0.5f)});
    const LayeredRadiance seen = layered_radiance(mesh, surfaces, radiance);
    ASSERT_EQ(seen.textured.size(), 4u);
    ASSERT_EQ(seen.added.size(), 4u);
    EXPECT_EQ(seen.textured[0], Rgb(2.0f));
    EXPECT_EQ(seen.added[0], Rgb(0.0f));
    EXPECT_EQ(seen.textured[1], Rgb(1.75f));  // 2 - 0.5 + 0.25
    EXPECT_EQ(seen.added[1], Rgb(0.5f));
    EXPECT_EQ(seen.textured[2], Rgb(1.875f));  // a quarter of the specular term does not depend on the image
    EXPECT_EQ(seen.added[2], Rgb(0.125f));
    EXPECT_EQ(seen.textured[3], Rgb(0.5f * 1.5f + 0.5f, 1.5f + 0.5f, 0.25f * 1.5f + 0.5f));
    EXPECT_EQ(seen.added[3], Rgb(0.0f));

    // The terms are those of the same surfaces with white images.
    std::vector<Surface> white = surfaces;
    for (Surface& surface : white) surface.texture = nullptr;
    white[1].emission = Rgb(0.25f);
    white[3].tinted_specular = 0.5f;
    const std::vector<Outgoing> diffuse(4, {Rgb(1.5f)});
    const std::vector<Rgb> highlights(4, Rgb(0.5f)), seen_d = layered_radiance(mesh, white, diffuse).textured,
                                                     seen_s = tinted_specular_light(mesh, white, highlights),
                                                     all = layered_radiance(mesh, white, radiance).textured;
    EXPECT_EQ(seen_d[1], Rgb(1.75f));
    EXPECT_EQ(seen_d[3], Rgb(0.75f, 1.5f, 0.375f));
    EXPECT_EQ(seen_s[2], Rgb(0.5f));
    EXPECT_EQ(seen_s[3], Rgb(0.375f, 0.5f, 0.3125f));  // half of it is multiplied by the colour
    for (std::size_t v = 0; v < 4; ++v) EXPECT_EQ(seen_d[v] + seen_s[v], all[v]) << v;
    EXPECT_EQ(layered_radiance(mesh, surfaces, diffuse).textured[1], Rgb(1.75f))
        << "images multiply it later";
    EXPECT_EQ(tinted_specular_light(mesh, surfaces, highlights)[1], Rgb(0.5f));

    for (Surface& surface : surfaces) surface.material.specular = Rgb(0.0f);
    EXPECT_TRUE(layered_radiance(mesh, surfaces, radiance).added.empty());
}

}  // namespace
}  // namespace haarfield
