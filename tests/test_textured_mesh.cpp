#include "bridge/povray/textured_mesh.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "bridge/pictures/preview.h"
#include "bridge/povray/baked_scene.h"
#include "bridge/povray/povray_process.h"
#include "bridge/povray/reference_scene.h"
#include "fields/file/write_file.h"
#include "shading/scene/environment.h"
#include "tests/fixtures/bridge_fixtures.h"
#include "tests/fixtures/example_textures.h"

namespace haarfield {
namespace {

constexpr int size = 48;

/// Returns a square that fills the picture, with the image repeated twice across and three times up.
Mesh mapped_square(int cells) {
    Mesh mesh = upright_square_mesh(1, cells);
    for (const Vec3f& p : mesh.positions) mesh.uvs.emplace_back(p.x + 0.3f, 1.5f * p.y - 0.2f);
    return mesh;
}

Image picture(const std::filesystem::path& scene) {
    PovrayOptions options;
    options.width = options.height = size;
    options.declarations = {without_background};
    Result<RenderedScene> rendered = rendered_scene(scene, options);
    EXPECT_TRUE(rendered) << rendered.error().message();
    return rendered ? rendered->image : Image{};
}

/// Returns the point of the square at a pixel's centre.
Vec3d point_at(std::size_t pixel) {
    return {(double(pixel % size) + 0.5) * 2 / size - 1, 1 - (double(pixel / size) + 0.5) * 2 / size, 0};
}

double image_channel(const Texture& texture, const Vec3d& p, std::size_t channel) {
    return bilinear_channel(texture, p.x + 0.3, 1.5 * p.y - 0.2, channel);
}

/// Light that is linear in the plane, so that interpolation over triangles is exact.
struct LinearLight {
    Rgb at(const Vec3d& p) const { return Rgb(Vec3f(Vec3d(1.5 + p.x, 1.2 - p.y, 0.8 + 0.3 * p.y))); }
    std::vector<Rgb> of(const Mesh& mesh, float times) const {
        std::vector<Rgb> values;
        for (const Vec3f& p : mesh.positions) values.push_back(at(Vec3d(p)) * times);
        return values;
    }
};

class TexturedMesh : public testing::Test {
protected:
    TexturedMesh() { surfaces[0].texture = texture; }

    const TestFolder folder;
    const std::shared_ptr<const Texture> texture = std::make_shared<const Texture>(random_texture(9, 7));
    std::vector<Surface> surfaces{1};
    const Mesh mesh = mapped_square(3);
    const LinearLight light{};
    const Camera camera = frontal_camera(3, size);
};

TEST_F(TexturedMesh, PovrayMultipliesTheImageWithTheLight) {
    const std::vector<Rgb> under = light.of(mesh, 1), over = light.of(mesh, 0.2f);
    for (const bool shines : {false, true}) {
        const BakedInstance instance{"square", &mesh, {}, under, shines ? over : std::span<const Rgb>(),
                                     surfaces};
        const Result<BakedFiles> files =
            write_baked_scene(folder.path(), "baked", camera, {&instance, 1}, {});
        ASSERT_TRUE(files) << files.error().message();
        EXPECT_EQ(files->images, (std::vector{folder / "baked_Random.png"}));
        const Image image = picture(files->scene);
        ASSERT_EQ(image.pixels.size(), std::size_t(size * size));
        for (std::size_t i = 0; i < image.pixels.size(); ++i) {
            const Vec3d p = point_at(i);
            for (std::size_t c = 0; c < 3; ++c) {
                const double here = double(light.at(p)[int(c)]),
                             expected = here * image_channel(*texture, p, c) + (shines ? 0.2 * here : 0);
                // 0.1 %, and the rounding of the picture to half floats.
                ASSERT_NEAR(image.pixels[i][int(c)], expected, 1e-3 * expected + 2e-5) << i << ", " << shines;
            }
        }
    }
}

/// As used for meshes of more than a million vertices.
TEST_F(TexturedMesh, PovrayMultipliesTheImageWithLightStoredInAnImage) {
    const std::vector<Rgb> under = light.of(mesh, 1), over = light.of(mesh, 0.2f);
    for (const bool has_image : {false, true})
        for (const bool shines : {false, true}) {
            surfaces[0].texture = has_image ? texture : nullptr;
            const Texture* const order[] = {surfaces[0].texture.get()};
            const Result<TextureFiles> files = write_textures(folder.path(), "large", order);
            ASSERT_TRUE(files) << files.error().message();
            const haarfield::TexturedMesh large =
                textured_mesh(mesh, surfaces, under, shines ? over : std::span<const Rgb>(), *files,
                              /*maps_all=*/true, "Large", "large");
            ASSERT_TRUE(large.mapped);
            EXPECT_EQ(large.textures, 1u);
            ASSERT_TRUE(large.mapped->write(folder.path()));
            ASSERT_TRUE(write_file(folder / "large.pov",
                                   "#version 3.7;\nglobal_settings { assumed_gamma 1 adc_bailout 0 }\n" +
                                       *povray_camera(camera) +
                                       "#declare Large_Finish = finish { emission 1 ambient 0 diffuse 0 }\n" +
                                       (has_image ? files->begin()->second.text : "") +
                                       large.mapped->declarations() + large.text + "}\n"));
            const Image image = picture(folder / "large.pov");
            ASSERT_EQ(image.pixels.size(), std::size_t(size * size));
            for (std::size_t i = 0; i < image.pixels.size(); ++i) {
                const Vec3d p = point_at(i);
                for (std::size_t c = 0; c < 3; ++c) {
                    const double here = double(light.at(p)[int(c)]),
                                 expected = !has_image ? here
                                                       : here * image_channel(*texture, p, c) +
                                                             (shines ? 0.2 * here : 0);
                    // 0.1 %, and positions in the image with 16 bits: texels differ by up to 1.
                    ASSERT_NEAR(image.pixels[i][int(c)], expected, 1e-3 * expected + 4e-4)
                        << i << ", " << has_image << ", " << shines;
                }
            }
        }
}

TEST_F(TexturedMesh, LightIsStoredInImagesWhereSixteenBitsSuffice) {
    Mesh wide = mesh;
    for (Vec2f& uv : wide.uvs) uv *= 2000;
    const std::vector<Rgb> under = light.of(mesh, 1);
    const Texture* const order[] = {texture.get()};
    const Result<TextureFiles> files = write_textures(folder.path(), "wide", order);
    ASSERT_TRUE(files) << files.error().message();
    const auto made = [&](const Mesh& of) {
        return textured_mesh(of, surfaces, under, {}, *files, /*maps_all=*/true, "Wide", "wide");
    };
    EXPECT_TRUE(made(mesh).mapped);
    EXPECT_FALSE(made(wide).mapped);
    wide.uvs = mesh.uvs;
    const std::uint32_t far = wide.triangles[0][1];
    wide.uvs[far] *= 2000;
    const haarfield::TexturedMesh mixed = made(wide);
    ASSERT_TRUE(mixed.mapped) << "but not for triangles that share a vertex";
    EXPECT_GT(mixed.textures, 1u);
}

TEST_F(TexturedMesh, MappedSliversHaveTheLightOfTheirMiddle) {
    Mesh sliver = upright_square_mesh(1, 1);
    sliver.triangles.resize(1);
    const auto& [a, b, c] = sliver.triangles[0];
    sliver.positions[c] = sliver.positions[a] + (sliver.positions[b] - sliver.positions[a]) * 0.5f;
    sliver.positions[c].y += 1e-9f;
    for (const Vec3f& p : sliver.positions) sliver.uvs.emplace_back(p.x, p.y);
    const Texture* const order[] = {texture.get()};
    const Result<TextureFiles> files = write_textures(folder.path(), "thin", order);
    ASSERT_TRUE(files) << files.error().message();
    const haarfield::TexturedMesh thin =
        textured_mesh(sliver, surfaces, light.of(sliver, 1), {}, *files, /*maps_all=*/true, "Thin", "thin");
    ASSERT_TRUE(thin.mapped);
    const std::string middle = fmt::format(",\n<{0},{0}>", (0.5f + 1.5f + 0.5f) / 3);
    EXPECT_NE(thin.text.find("uv_vectors { 3" + middle + middle + middle), std::string::npos) << thin.text;
}

TEST_F(TexturedMesh, ThePreviewShowsTheSame) {
    const std::vector<Rgb> under = light.of(mesh, 1), over = light.of(mesh, 0.2f);
    const BakedInstance instance{"", &mesh, {}, under, over, surfaces};
    const auto points = Preview().points(camera, {&instance, 1});
    Camera fine = camera;  // so fine that pixels equal their neighbours and have one ray each
    fine.vertical_fov = camera.vertical_fov / 200;
    const Image image = Preview().draw(fine, {&instance, 1}, [](const Vec3f&) { return Rgb(0.0f); });
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        const Vec3d p = point_at(i) * (std::tan(double(fine.vertical_fov) / 2) * 3);
        for (std::size_t c = 0; c < 3; ++c) {
            const double here = double(light.at(p)[int(c)]);
            ASSERT_NEAR(image.pixels[i][int(c)], here * image_channel(*texture, p, c) + 0.2 * here, 2e-3);
        }
    }
}

TEST_F(TexturedMesh, WhereTheImageIsNotOpaqueThereIsNoSurface) {
    Texture holed = random_texture(4, 4, true);
    for (auto& texel : holed.texels) texel = {255, 255, 255, 255};
    holed.texels[5][3] = 0;
    surfaces[0].texture = std::make_shared<const Texture>(holed);
    // POV-Ray treats values above 1 as more opaque.
    const std::vector<Rgb> under = light.of(mesh, 0.25f), over = light.of(mesh, 0.125f);
    const BakedInstance instance{"square", &mesh, {}, under, over, surfaces};
    const Result<BakedFiles> files = write_baked_scene(folder.path(), "baked", camera, {&instance, 1}, {});
    ASSERT_TRUE(files) << files.error().message();
    const Image image = picture(files->scene);
    ASSERT_FALSE(image.coverage.empty());
    std::size_t open = 0;
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        const double opacity = image_channel(holed, point_at(i), 3);
        ASSERT_NEAR(image.coverage[i], opacity, 5e-3) << i;
        for (int c = 0; c < 3; ++c)
            ASSERT_NEAR(image.pixels[i][c], 0.375 * double(light.at(point_at(i))[c]) * opacity, 2e-3) << i;
        open += opacity < 0.3;
    }
    EXPECT_GT(open, 10u);
    // The preview's rays pass where less than half is opaque.
    const BakedInstance shown{"", &mesh, {}, under, over, surfaces};
    const auto points = Preview().points(camera, {&shown, 1});
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double opacity = image_channel(holed, point_at(i), 3);
        if (std::abs(opacity - 0.5) > 0.01) {
            ASSERT_EQ(points[i].has_value(), opacity > 0.5) << i;
        }
    }
}

/// Also behind a sheet whose sides are closer to each other than POV-Ray can distinguish.
TEST_F(TexturedMesh, SurfacesBehindTheHolesOfASheetAreVisible) {
    Texture holed = random_texture(4, 4, true);
    for (std::size_t i = 0; i < holed.texels.size(); ++i) holed.texels[i][3] = i % 4 < 2 ? 255 : 0;
    surfaces[0].texture = std::make_shared<const Texture>(holed);
    Mesh back = mesh, scene = mesh, wall = upright_square_mesh(1.5f);
    for (auto& [a, b, c] : back.triangles) std::swap(b, c);
    for (Vec3f& normal : back.normals) normal = -normal;
    wall.uvs.assign(wall.positions.size(), Vec2f(0.25f, 0.5f));  // opaque
    for (Vec3f& p : wall.positions) p.z = -0.3f;
    for (Vec3f& p : scene.positions) p.z = 1e-5f;
    append_mesh(scene, back);
    append_mesh(scene, wall);
    std::vector<Rgb> under(scene.positions.size(), Rgb(0.25f)), over(under.size(), Rgb(0.0625f));
    for (std::size_t v = under.size() - wall.positions.size(); v < under.size(); ++v) over[v] = Rgb(0.5f);
    const BakedInstance instance{"sheet", &scene, {}, under, over, surfaces};
    const Result<BakedFiles> files = write_baked_scene(folder.path(), "baked", camera, {&instance, 1}, {});
    ASSERT_TRUE(files) << files.error().message();
    const Image image = picture(files->scene);
    const double wall_colour = 0.25 * bilinear_channel(holed, 0.25, 0.5, 0) + 0.5;
    std::size_t in_holes = 0, on_sheet = 0;
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        const double opacity = image_channel(holed, point_at(i), 3);
        if (opacity == 0) {
            ASSERT_NEAR(image.pixels[i].x, wall_colour, 5e-3) << i;
            ++in_holes;
        } else if (opacity == 1) {
            ASSERT_NEAR(image.pixels[i].x, 0.25 * image_channel(holed, point_at(i), 0) + 0.0625, 5e-3) << i;
            ++on_sheet;
        }
    }
    EXPECT_GT(in_holes, 10u);
    EXPECT_GT(on_sheet, 10u);
}

/// Under uniform light, the radiance of a diffuse square is its albedo.
TEST_F(TexturedMesh, TheReferenceShowsImageColoursAndEmission) {
    Mesh coloured = mesh;
    for (const Vec3f& p : mesh.positions) coloured.colours.emplace_back(0.5f + 0.4f * p.x, 1.0f, 0.7f);
    for (const Rgb& factor : {Rgb(0.5f), Rgb(0.9f, 0.5f, 0.25f)})
        for (const bool has_colours : {false, true}) {
            surfaces[0].material.diffuse = factor;
            surfaces[0].emission = Rgb(0.1f, 0.0f, 0.3f);
            surfaces[0].coloured = has_colours;
            const std::vector<Material> materials = materials_of(surfaces);
            const ReferenceInstance instance{"square", &coloured, materials, {}, surfaces};
            const LatLongImage white = constant_environment(64, Rgb(1, 1, 1));
            const Result<ReferenceFiles> files =
                write_reference_scene(folder.path(), "reference", camera, {&instance, 1}, white, 400);
            ASSERT_TRUE(files) << files.error().message();
            EXPECT_TRUE(files->warnings.empty());
            const Image image = picture(files->scene);
            ASSERT_EQ(image.pixels.size(), std::size_t(size * size));
            double worst = 0, level = 0;  // of the lights, over the whole picture
            for (std::size_t i = 0; i < image.pixels.size(); ++i) {
                const Vec3d p = point_at(i);
                const Vec3d colour = has_colours ? Vec3d(0.5 + 0.4 * p.x, 1, 0.7) : Vec3d(1.0);
                for (std::size_t c = 0; c < 3; ++c) {
                    const double albedo = image_channel(*texture, p, c) * colour[int(c)],
                                 expected = albedo * double(factor[int(c)] + surfaces[0].emission[int(c)]);
                    worst = std::max(
                        worst, std::abs(double(image.pixels[i][int(c)]) - expected) / (expected + 0.01));
                    level += expected;
                }
            }
            EXPECT_LT(worst, 0.01) << factor.x << ", " << has_colours;
            EXPECT_GT(level, 0);
        }
}

/// The picture of a metal is that of its specular term without an image, multiplied by a tint at each pixel.
TEST_F(TexturedMesh, TheReferenceTintsTheSpecularLobesOfMetalsByImages) {
    Mesh coloured = mesh;
    for (const Vec3f& p : mesh.positions) coloured.colours.emplace_back(0.5f + 0.4f * p.x, 1.0f, 0.7f);
    const auto rendered = [&](const Surface& surface) {
        const std::vector<Material> materials{surface.material};
        const ReferenceInstance instance{"square", &coloured, materials, {}, {&surface, 1}};
        const Result<ReferenceFiles> files = write_reference_scene(
            folder.path(), "reference", camera, {&instance, 1}, constant_environment(64, Rgb(1, 1, 1)), 400);
        EXPECT_TRUE(files) << files.error().message();
        EXPECT_TRUE(files->warnings.empty());
        return picture(files->scene);
    };
    Surface white;
    white.material.convention = LobeConvention::povray;
    white.material.diffuse = Rgb(0.0f);
    white.material.specular = Rgb(1.0f);
    white.material.shininess = 12;
    white.material.phong = 3;
    const Image highlights = rendered(white);
    for (const bool has_image : {true, false})
        for (const bool has_colours : {false, true})
            for (const auto& [tinted, diffuse] : {std::pair(1.0f, 0.0f), std::pair(0.6f, 0.2f)}) {
                Surface metal = white;
                if (has_image) metal.texture = texture;
                metal.coloured = has_colours;
                metal.tinted_specular = tinted;
                metal.material.diffuse = Rgb(diffuse, diffuse / 2, diffuse / 4);
                metal.material.specular = Rgb(0.9f, 0.6f, 0.3f);
                metal.emission = Rgb(diffuse, 0, diffuse);
                const Image image = rendered(metal);
                ASSERT_EQ(image.pixels.size(), std::size_t(size * size));
                for (std::size_t i = 0; i < image.pixels.size(); ++i) {
                    const Vec3d p = point_at(i);
                    const Vec3d colour = has_colours ? Vec3d(0.5 + 0.4 * p.x, 1, 0.7) : Vec3d(1.0);
                    for (std::size_t c = 0; c < 3; ++c) {
                        const double shine = double(metal.material.specular[int(c)]) *
                                             double(highlights.pixels[i][int(c)]),
                                     under = (has_image ? image_channel(*texture, p, c) : 1) * colour[int(c)],
                                     expected = under * (double(metal.material.diffuse[int(c)]) +
                                                         double(metal.emission[int(c)])) +
                                                shine * (under * double(tinted) + 1 - double(tinted));
                        ASSERT_NEAR(image.pixels[i][int(c)], expected, 0.01 * expected + 1e-3)
                            << i << ", " << has_image << has_colours << ", " << tinted;
                    }
                }
            }
}

/// On an empty background, the picture's opacity is that of the image.
TEST_F(TexturedMesh, TheReferenceHasTheHolesOfItsImages) {
    Texture holed = random_texture(4, 4, true);
    holed.texels[5][3] = 0;
    surfaces[0].texture = std::make_shared<const Texture>(holed);
    for (const Rgb& factor : {Rgb(0.5f), Rgb(0.9f, 0.5f, 0.25f)}) {
        surfaces[0].material.diffuse = factor;
        const std::vector<Material> materials = materials_of(surfaces);
        const ReferenceInstance instance{"square", &mesh, materials, {}, surfaces};
        const Result<ReferenceFiles> files = write_reference_scene(
            folder.path(), "reference", camera, {&instance, 1}, constant_environment(64, Rgb(1, 1, 1)), 400);
        ASSERT_TRUE(files) << files.error().message();
        const Image image = picture(files->scene);
        ASSERT_FALSE(image.coverage.empty());
        for (std::size_t i = 0; i < image.pixels.size(); ++i) {
            const double opacity = image_channel(holed, point_at(i), 3);
            ASSERT_NEAR(image.coverage[i], opacity, 5e-3) << i << ", " << factor.x;
            for (std::size_t c = 0; c < 3; ++c) {
                const double expected =
                    image_channel(holed, point_at(i), c) * double(factor[int(c)]) * opacity;
                ASSERT_NEAR(image.pixels[i][int(c)], expected, 0.01 * expected + 1e-3)
                    << i << ", " << factor.x;
            }
        }
    }
}

/// Holes have no specular reflection either, unlike glass.
TEST_F(TexturedMesh, TheReferenceHasNoSpecularLightInHoles) {
    Texture holed = random_texture(4, 4, true);
    holed.texels[5][3] = 0;
    Texture whole = holed;
    whole.has_alpha = false;
    for (auto& texel : whole.texels) texel[3] = 255;
    Surface& surface = surfaces[0];
    surface.material.shininess = 20;
    surface.material.convention = LobeConvention::physical;
    for (const Rgb& tint : {Rgb(1.0f), Rgb(0.9f, 0.5f, 0.25f)}) {
        surface.material.diffuse = tint * 0.2f;
        surface.material.specular = tint * 0.5f;
        std::array<Image, 2> images;
        for (std::size_t k = 0; k < 2; ++k) {
            surface.texture = std::make_shared<const Texture>(k == 0 ? holed : whole);
            const std::vector<Material> materials = materials_of(surfaces);
            const ReferenceInstance instance{"square", &mesh, materials, {}, surfaces};
            const Result<ReferenceFiles> files =
                write_reference_scene(folder.path(), "reference", camera, {&instance, 1},
                                      constant_environment(64, Rgb(1, 1, 1)), 400);
            ASSERT_TRUE(files) << files.error().message();
            images[k] = picture(files->scene);
        }
        double highlight = 0;
        for (std::size_t i = 0; i < images[0].pixels.size(); ++i) {
            const double opacity = image_channel(holed, point_at(i), 3);
            ASSERT_NEAR(images[0].coverage[i], opacity, 5e-3) << i << ", " << tint.y;
            for (std::size_t c = 0; c < 3; ++c) {
                const double expected = double(images[1].pixels[i][int(c)]) * opacity;
                ASSERT_NEAR(images[0].pixels[i][int(c)], expected, 0.01 * expected + 2e-3)
                    << i << ", " << tint.y;
                highlight = std::max(highlight, expected);
            }
        }
        EXPECT_GT(highlight, 0.3);  // far above the diffuse radiance of 0.2
    }
}

}  // namespace
}  // namespace haarfield
