#include "scenes/texture.h"

#include <gtest/gtest.h>

#include "tests/fixtures/example_textures.h"

namespace haarfield {
namespace {

TEST(Texture, IsBilinearAndRepeats) {
    const Texture texture = random_texture(7, 4, true);
    std::mt19937 random(1);
    for (int i = 0; i < 300; ++i) {
        const Vec2f uv(uniform(random, -3.0f, 3.0f), uniform(random, -3.0f, 3.0f));
        const Rgb found = texture.colour_at(uv);
        for (std::size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(found[int(c)], bilinear_channel(texture, double(uv.x), double(uv.y), c), 1e-5)
                << uv.x;
        EXPECT_NEAR(texture.opacity_at(uv), bilinear_channel(texture, double(uv.x), double(uv.y), 3), 1e-5);
    }
}

TEST(Texture, OriginIsTheLowerLeftCorner) {
    Texture texture = random_texture(2, 2);
    texture.texels = {{0, 0, 0, 255}, {0, 0, 0, 255}, {255, 0, 0, 255}, {0, 255, 0, 255}};
    EXPECT_NEAR(texture.colour_at({0.25f, 0.25f}).x, 1, 1e-6);
    EXPECT_NEAR(texture.colour_at({0.75f, 0.25f}).y, 1, 1e-6);
}

TEST(Texture, ReadsWhatWasWritten) {
    const TestFolder folder;
    const Texture written = random_texture(5, 3, true);
    write_png(written, folder / "a.png");
    const MeshImage image{"a.png", folder / "a.png", nullptr};
    const Result<Texture> read = read_texture({image, {}, AlphaMode::blend});
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_EQ(read->texels, written.texels);
    EXPECT_TRUE(read->has_alpha);
    EXPECT_EQ(read->name, "a");
    EXPECT_TRUE(read->jpeg.empty());
    double mean = 0;
    for (int i = 0; i < 15; ++i) mean += linear_channel(written, i % 5, i / 5, 1) / 15;
    EXPECT_NEAR(read->mean.y, mean, 1e-6);

    // Embedded, the result is the same.
    const auto bytes = std::make_shared<const std::string>(text_of(folder / "a.png"));
    const Result<Texture> embedded = read_texture({{"b", {}, bytes}, {}, AlphaMode::blend});
    ASSERT_TRUE(embedded) << embedded.error().message();
    EXPECT_EQ(embedded->texels, written.texels);
    const Result<Texture> broken =
        read_texture({{"b", {}, std::make_shared<const std::string>("no image")}, {}, AlphaMode::opaque});
    EXPECT_FALSE(broken);
}

TEST(Texture, AlphaIsWhatItsModeSays) {
    const TestFolder folder;
    Texture half = random_texture(2, 1, true);
    half.texels[0][3] = 100;
    half.texels[1][3] = 200;
    write_png(half, folder / "a.png");
    const MeshImage image{"a.png", folder / "a.png", nullptr};
    EXPECT_FALSE(read_texture({image, {}, AlphaMode::opaque})->has_alpha);
    const Texture blended = *read_texture({image, {}, AlphaMode::blend});
    EXPECT_EQ(blended.texels[0][3], 100);
    const Texture masked = *read_texture({image, {}, AlphaMode::mask, 0.5f});
    EXPECT_EQ(masked.texels[0][3], 0);
    EXPECT_EQ(masked.texels[1][3], 255);
    // A separate map of a different size: its luminance counts.
    Texture map = random_texture(4, 1);
    map.texels = {{0, 0, 0, 255}, {0, 0, 0, 255}, {255, 255, 255, 255}, {255, 255, 255, 255}};
    write_png(map, folder / "map.png");
    const MeshImage opacity{"map.png", folder / "map.png", nullptr};
    const Texture mapped = *read_texture({image, opacity, AlphaMode::mask, 0.5f});
    EXPECT_EQ(mapped.texels[0][3], 0);
    EXPECT_EQ(mapped.texels[1][3], 255);
}

TEST(Texture, CutOutsAreFoundWhereTrianglesTouchThem) {
    Texture texture = random_texture(16, 16);
    EXPECT_FALSE(texture.is_cut_out({Vec2f(0, 0), Vec2f(1, 0), Vec2f(0, 1)}));
    texture.has_alpha = true;
    texture.texels[16 * 3 + 12][3] = 0;  // column 12, row 3 from the top
    const auto at = [](float column, float row) { return Vec2f(column / 16, 1 - row / 16); };
    EXPECT_TRUE(texture.is_cut_out({at(12, 3), at(13, 3), at(12.5f, 4)}));
    // through bilinear interpolation
    EXPECT_TRUE(texture.is_cut_out({at(11, 2), at(11.6f, 2), at(11.6f, 3)}));
    EXPECT_FALSE(texture.is_cut_out({at(2, 2), at(5, 2), at(5, 9)}));
    EXPECT_TRUE(texture.is_cut_out(
        {at(12, 3) + Vec2f(5, -7), at(13, 3) + Vec2f(5, -7), at(12.5f, 4) + Vec2f(5, -7)}));
    EXPECT_TRUE(texture.is_cut_out({Vec2f(-40, 0), Vec2f(40, 0), Vec2f(0, 40)}));
}

}  // namespace
}  // namespace haarfield
