#include "tools/view/light_shelf.h"

#include <gtest/gtest.h>

#include "scenes/image.h"
#include "tests/fixtures/test_folder.h"

namespace haarfield {
namespace {

/// A shelf with a sky and an image of 4 x 2 pixels, as the bytes of a file.
struct Shelf {
    Shelf() : shelf(sky(), "", folder / "lights") {}

    static EnvironmentDescription sky() {
        EnvironmentDescription description;
        description.sky = AnalyticSky{};
        return description;
    }

    std::string panorama(const std::string& ending) const {
        const Image image{4, 2, std::vector<Rgb>(8, Rgb(0.5f)), {}};
        const std::filesystem::path file = folder / ("panorama" + ending);
        EXPECT_TRUE(bool(write_image(image, file)));
        return text_of(file);
    }

    /// Adds a light. Returns its name, or an empty string if the shelf rejects it.
    std::string added(std::string_view name, std::string_view bytes) {
        const Result<std::string> result = shelf.add(name, bytes);
        return result ? *result : "";
    }

    TestFolder folder;
    LightShelf shelf;
};

TEST(ViewLightShelf, NumbersTheStemOfANameThatIsTaken) {
    Shelf opened;
    const std::string bytes = opened.panorama(".exr");
    EXPECT_EQ(opened.added("noon.exr", bytes), "noon.exr");
    EXPECT_EQ(opened.added("noon.exr", bytes), "noon_2.exr");
    EXPECT_EQ(opened.added("noon.exr", bytes), "noon_3.exr");
    EXPECT_TRUE(std::filesystem::exists(opened.folder / "lights" / "noon_3.exr"));
}

TEST(ViewLightShelf, AcceptsEveryFormatThatImagesAreReadIn) {
    Shelf opened;
    const std::string png = opened.panorama(".png");
    EXPECT_EQ(opened.added("noon.png", png), "noon.png");
    EXPECT_EQ(opened.added("named wrongly.jpg", png), "named_wrongly.jpg");
    const Result<LatLongImage> read = read_environment_image(opened.shelf.find("noon.png")->image);
    ASSERT_TRUE(bool(read));
    EXPECT_NEAR(read->pixels[0].x, 0.5f, 0.005f);  // 8 bit images are sRGB
}

TEST(ViewLightShelf, StoresNothingThatIsNoLatLongImage) {
    Shelf opened;
    EXPECT_EQ(opened.added("script.exr", "<script>"), "");
    EXPECT_EQ(opened.added(".exr", opened.panorama(".exr")), "");
    const Image square{2, 2, std::vector<Rgb>(4, Rgb(0.5f)), {}};
    EXPECT_EQ(opened.added("square.png", *png_bytes(square)), "");
    EXPECT_EQ(opened.shelf.lights().size(), 1u);
    EXPECT_FALSE(std::filesystem::exists(opened.folder / "lights" / "square.png"));
}

}  // namespace
}  // namespace haarfield
