#include "bridge/povray/coloured_mesh.h"

#include <random>

#include "bridge/povray/povray_process.h"
#include "fields/file/write_file.h"
#include "fields/model/mesh2_file.h"
#include "tests/fixtures/bridge_fixtures.h"

namespace haarfield {
namespace {

/// Returns radiances that differ by a factor of up to five.
std::vector<Rgb> random_colours(std::size_t count, bool grey) {
    std::mt19937 random(7);
    const auto channel = [&] { return 0.4f + 1.6f * static_cast<float>(random() % 1000) / 1000; };
    std::vector<Rgb> colours(count);
    for (Rgb& colour : colours) {
        colour = Rgb(channel());
        if (!grey) colour = Rgb(colour.x, channel(), channel());
    }
    return colours;
}

/// Returns an upright wavy board.
Mesh wavy_mesh(float half_edge) {
    Mesh mesh = upright_square_mesh(half_edge, 6);
    for (Vec3f& p : mesh.positions) p.z = 0.3f * half_edge * std::sin(3 * p.x / half_edge);
    return mesh;
}

/// Renders the mesh twice: as `mesh2`, and rotated as a separate object.
Image picture_of(const Mesh& mesh, std::span<const Rgb> colours, ColourStorage storage, float distance,
                 const TestFolder& folder) {
    const ColouredMesh coloured = coloured_mesh(mesh, colours, storage, "Glow", "atlas.exr");
    EXPECT_EQ(coloured.atlas.pixels.empty(), storage != ColourStorage::atlas);
    if (!coloured.atlas.pixels.empty()) {
        EXPECT_TRUE(write_image(coloured.atlas, folder / "atlas.exr"));
    }
    Camera camera = frontal_camera(distance, 80);
    camera.vertical_fov = 0.6f;
    EXPECT_TRUE(write_file(
        folder / "mesh.pov",
        "#version 3.7;\nglobal_settings { assumed_gamma 1 adc_bailout 0 }\n" + *povray_camera(camera) +
            "#declare Glow = finish { emission 1 ambient 0 diffuse 0 }\n#declare M = " + coloured.text +
            "rotate <10, 0, 20> }\nobject { M rotate <0, 40, 0> }\n"));
    PovrayOptions options;
    options.width = options.height = 80;
    Result<RenderedScene> rendered = rendered_scene(folder / "mesh.pov", options);
    EXPECT_TRUE(rendered) << rendered.error().message();
    return rendered->image;
}

TEST(ColouredMesh, LooksTheSameForEveryColourStorage) {
    for (const float half_edge : {1.0f, 0.004f}) {
        const TestFolder folder;
        const Mesh mesh = wavy_mesh(half_edge);
        for (const bool grey : {false, true}) {
            const std::vector<Rgb> colours = random_colours(mesh.positions.size(), grey);
            const Image expected = picture_of(mesh, colours, ColourStorage::textures, 4 * half_edge, folder);
            for (const ColourStorage storage : {ColourStorage::atlas, ColourStorage::grey_textures}) {
                if (storage == ColourStorage::grey_textures && !grey) continue;
                const Image image = picture_of(mesh, colours, storage, 4 * half_edge, folder);
                std::size_t covered = 0;
                for (std::size_t i = 0; i < image.pixels.size(); ++i) {
                    ASSERT_EQ(image.coverage[i], expected.coverage[i]);
                    if (image.coverage[i] == 0) continue;
                    ++covered;
                    for (int c = 0; c < 3; ++c)
                        EXPECT_NEAR(image.pixels[i][c] / expected.pixels[i][c], 1, 2e-3)
                            << half_edge << " m, storage " << int(storage) << ", pixel " << i;
                }
                EXPECT_GT(covered, 500u);
            }
        }
    }
}

TEST(ColouredMesh, IsReadBackWhereItWas) {
    Mesh mesh = wavy_mesh(0.004f);  // rotated and magnified for POV-Ray
    for (Vec3f& p : mesh.positions) p += Vec3f(0.01f, 0.02f, -0.03f);
    const std::vector<Rgb> colours = random_colours(mesh.positions.size(), true);
    for (const ColourStorage storage :
         {ColourStorage::textures, ColourStorage::grey_textures, ColourStorage::atlas}) {
        const std::string text = "#declare Glow = finish { emission 1 }\n#declare M = " +
                                 coloured_mesh(mesh, colours, storage, "Glow", "a.exr").text +
                                 "scale 2 translate <1, 2, 3> }\n";
        const Result<Mesh2File> file = read_mesh2(text);
        ASSERT_TRUE(file) << file.error().message();
        ASSERT_EQ(file->meshes.size(), 1u);
        const Mesh2& back = file->meshes[0];
        EXPECT_EQ(back.name, "M");
        ASSERT_EQ(back.positions.size(), mesh.positions.size());
        for (std::size_t i = 0; i < mesh.positions.size(); ++i)
            EXPECT_LT((back.positions[i] - (mesh.positions[i] * 2.0f + Vec3f(1, 2, 3))).length(), 1e-6f) << i;
        ASSERT_EQ(back.faces.size(), mesh.triangles.size());
        for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
            EXPECT_EQ(back.faces[i].positions, mesh.triangles[i]) << i;
    }
}

TEST(ColouredMesh, NeedsFewTexturesForManyGreys) {
    const Mesh mesh = upright_square_mesh(1, 300);
    std::vector<Rgb> colours;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i)
        colours.push_back(
            Rgb(0.1f + 0.9f * static_cast<float>(i) / static_cast<float>(mesh.positions.size())));
    EXPECT_EQ(coloured_mesh(mesh, colours, ColourStorage::textures, "F", "").textures, colours.size());
    const std::size_t greys = coloured_mesh(mesh, colours, ColourStorage::grey_textures, "F", "").textures;
    EXPECT_GT(greys, 3000u);
    EXPECT_LT(greys, 4096u);
}

TEST(ColouredMesh, StorageSuitsNumberAndHue) {
    const auto storage = [](std::size_t count, const Rgb& last) {
        std::vector<Rgb> colours(count, Rgb(0.5f));
        colours.back() = last;
        return colour_storage(colours);
    };
    const Rgb grey(0.25f), reddish(0.25f, 0.25f, 0.2f);
    EXPECT_EQ(storage(200000, grey), ColourStorage::textures);
    EXPECT_EQ(storage(200001, grey), ColourStorage::grey_textures);
    EXPECT_EQ(storage(200001, reddish), ColourStorage::textures);
    EXPECT_EQ(storage(1000001, grey), ColourStorage::grey_textures);
    EXPECT_EQ(storage(1000000, reddish), ColourStorage::textures);
    EXPECT_EQ(storage(1000001, reddish), ColourStorage::atlas);
}

}  // namespace
}  // namespace haarfield
