#include "scenes/image.h"

#include "fields/file/write_file.h"
#include "tests/fixtures/bridge_fixtures.h"

#include <array>
#include <cstdint>
#include <random>

namespace haarfield {
namespace {

Image random_image(int width, int height, bool with_coverage, unsigned seed) {
    std::mt19937 random(seed);
    const auto uniform = [&] { return static_cast<float>(random()) / 4294967296.0f; };
    Image image{width, height, {}, {}};
    for (int i = 0; i < width * height; ++i) {
        image.pixels.emplace_back(uniform() * 20, uniform(), uniform() * 0.01f);
        if (with_coverage) image.coverage.push_back(uniform());
    }
    return image;
}

TEST(Image, ExrKeepsRadianceAndCoverageToHalfPrecision) {
    const TestFolder folder;
    for (bool with_coverage : {false, true}) {
        const Image image = random_image(13, 7, with_coverage, 1);
        ASSERT_TRUE(write_image(image, folder / "a.exr"));
        const Result<Image> back = read_image(folder / "a.exr");
        ASSERT_TRUE(back) << back.error().message();
        ASSERT_EQ(back->width, 13);
        ASSERT_EQ(back->height, 7);
        ASSERT_EQ(back->coverage.size(), image.coverage.size());
        for (std::size_t i = 0; i < image.pixels.size(); ++i) {
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(back->pixels[i][c], image.pixels[i][c], 4.9e-4 * image.pixels[i][c] + 3e-8) << i;
            if (with_coverage) {
                EXPECT_NEAR(back->coverage[i], image.coverage[i], 4.9e-4) << i;
            }
        }
    }
}

TEST(Image, ExrKeepsTheEstimatedError) {
    const TestFolder folder;
    Image image = random_image(3, 2, true, 1);
    ASSERT_TRUE(write_image(image, folder / "a.exr"));
    EXPECT_FALSE(read_image(folder / "a.exr")->relative_error);
    image.relative_error = 0.0125f;
    ASSERT_TRUE(write_image(image, folder / "a.exr"));
    EXPECT_EQ(read_image(folder / "a.exr")->relative_error, 0.0125f);
}

TEST(Image, PngHoldsTheSrgbCurve) {
    const TestFolder folder;
    // Codes of the sRGB standard: linear 0.2140411 is code 127.5, 0.0003035 is code 1; beyond 1 is clamped.
    const Image image{
        4, 1, {Rgb(0.2158605f, 0.2122308f, 0.0003035f), Rgb(1, 0, 5), Rgb(-1, 0.5f, 0.5f), Rgb(0, 0, 0)}, {}};
    ASSERT_TRUE(write_image(image, folder / "a.png"));
    const Result<Image> back = read_image(folder / "a.png");
    ASSERT_TRUE(back) << back.error().message();
    EXPECT_NEAR(back->pixels[0].x, 0.2158605f, 1e-6);  // 128
    EXPECT_NEAR(back->pixels[0].y, 0.2122308f, 1e-6);  // 127
    EXPECT_NEAR(back->pixels[0].z, 0.0003035f, 1e-7);  // 1
    EXPECT_NEAR(back->pixels[1].z, 1.0f, 1e-6);
    EXPECT_NEAR(back->pixels[2].x, 0.0f, 1e-6);
    EXPECT_NEAR(back->pixels[2].y, 0.5028865f, 1e-5);  // 188
    EXPECT_TRUE(back->coverage.empty());
}

TEST(Image, SrgbEncodingAndDecodingAreInverse) {
    for (int i = 0; i <= 1000; ++i) {
        const float linear = static_cast<float>(i) / 1000;
        EXPECT_NEAR(srgb_decoded(srgb_encoded(linear)), linear, 2e-6);
    }
    EXPECT_EQ(srgb_encoded(NAN), 0.0f);
    EXPECT_EQ(srgb_encoded(-1), 0.0f);
    EXPECT_EQ(srgb_encoded(2), 1.0f);
}

TEST(Image, PngWithCoverageIsDividedByIt) {
    const TestFolder folder;
    const Image image{2, 1, {Rgb(0.25f, 0.5f, 0), Rgb(0, 0, 0)}, {0.5f, 0}};
    const Result<std::string> bytes = png_bytes(image);
    ASSERT_TRUE(bytes);
    ASSERT_TRUE(write_file(folder / "a.png", *bytes));
    const Result<Image> back = read_image(folder / "a.png");
    ASSERT_TRUE(back);
    ASSERT_EQ(back->coverage.size(), 2u);
    EXPECT_NEAR(back->coverage[0], 0.5, 0.003);
    EXPECT_EQ(back->coverage[1], 0.0f);
    EXPECT_NEAR(back->pixels[0].x, 0.5, 0.005);
    EXPECT_NEAR(back->pixels[0].y, 1.0, 0.005);
}

TEST(Image, OverAddsTheBackgroundThatIsNotCovered) {
    const Image image{2, 1, {Rgb(0.25f, 0, 0), Rgb(0.5f, 0.5f, 0.5f)}, {0.75f, 1}};
    const Image background{2, 1, {Rgb(4, 4, 4), Rgb(4, 4, 4)}, {}};
    const Image result = over(image, background);
    EXPECT_EQ(result.pixels[0], Rgb(1.25f, 1, 1));
    EXPECT_EQ(result.pixels[1], Rgb(0.5f, 0.5f, 0.5f));
    EXPECT_TRUE(result.coverage.empty());
}

TEST(Image, RefusesNonFiniteRadianceAndOtherEndingsAndLeavesNothing) {
    const TestFolder folder;
    Image image = random_image(3, 3, true, 2);
    EXPECT_FALSE(write_image(image, folder / "a.jpg"));
    EXPECT_FALSE(write_image(image, folder / "missing/a.exr"));
    EXPECT_FALSE(write_image(Image{}, folder / "a.exr"));
    for (float bad : {NAN, INFINITY, -INFINITY}) {
        Image broken = image;
        broken.pixels[4].y = bad;
        const Result<Done> written = write_image(broken, folder / "a.exr");
        ASSERT_FALSE(written);
        EXPECT_NE(written.error().what.find("(1, 1)"), std::string::npos) << written.error().message();
        broken = image;
        broken.coverage[0] = bad;
        EXPECT_FALSE(write_image(broken, folder / "a.png"));
    }
    EXPECT_TRUE(folder.files().empty());
}

TEST(Image, RefusesAFileCutShortAnywhere) {
    const TestFolder folder;
    const Image image = random_image(9, 5, true, 3);
    for (const char* name : {"a.exr", "a.png"}) {
        ASSERT_TRUE(write_image(image, folder / name));
        const std::string whole = text_of(folder / name);
        // The last 12 bytes of a PNG only mark its end.
        for (std::size_t length = 0; length + 13 < whole.size(); length += 7) {
            ASSERT_TRUE(write_file(folder / name, whole.substr(0, length)));
            EXPECT_FALSE(read_image(folder / name)) << name << " cut to " << length << " of " << whole.size();
        }
    }
    EXPECT_FALSE(read_image(folder / "missing.exr"));
    ASSERT_TRUE(write_file(folder / "text.png", "this is no picture"));
    EXPECT_FALSE(read_image(folder / "text.png"));
}

template <class T>
std::string bytes_of(const T& value) {
    return {reinterpret_cast<const char*>(&value), sizeof value};
}

/// Returns an EXR file of 2 x 2 pixels without samples.
std::string deep_exr() {
    std::string file = bytes_of(std::uint32_t{20000630}) + bytes_of(std::uint32_t{2 | 1 << 11});
    const auto add = [&](const std::string& name, const std::string& type, const std::string& value) {
        file += name + '\0' + type + '\0' + bytes_of(static_cast<std::uint32_t>(value.size())) + value;
    };
    std::string channels;
    for (const char* name : {"A", "B", "G", "R", "Z"})
        channels += name + std::string(1, '\0') + bytes_of(std::array<std::int32_t, 4>{2, 0, 1, 1});
    const std::string window = bytes_of(std::array<std::int32_t, 4>{0, 0, 1, 1});
    add("channels", "chlist", channels + '\0');
    add("chunkCount", "int", bytes_of(std::int32_t{2}));
    add("compression", "compression", std::string(1, '\0'));
    add("dataWindow", "box2i", window);
    add("displayWindow", "box2i", window);
    add("lineOrder", "lineOrder", std::string(1, '\0'));
    add("maxSamplesPerPixel", "int", bytes_of(std::int32_t{0}));
    add("pixelAspectRatio", "float", bytes_of(1.0f));
    add("screenWindowCenter", "v2f", bytes_of(std::array<float, 2>{}));
    add("screenWindowWidth", "float", bytes_of(1.0f));
    add("type", "string", "deepscanline");
    add("version", "int", bytes_of(std::int32_t{1}));
    file += '\0';
    const std::string counts = std::string(8, '\0');
    const std::uint64_t first = file.size() + 16, chunk = 4 + 3 * 8 + counts.size();
    file += bytes_of(first) + bytes_of(first + chunk);
    for (const std::int32_t row : {0, 1})
        file += bytes_of(row) + bytes_of(std::array<std::uint64_t, 3>{8, 0, 0}) + counts;
    return file;
}

TEST(Image, SaysThatDeepPixelsCannotBeRead) {
    const TestFolder folder;
    ASSERT_TRUE(write_file(folder / "deep.exr", deep_exr()));
    const Result<Image> read = read_image(folder / "deep.exr");
    ASSERT_FALSE(read);
    EXPECT_NE(read.error().what.find("deep data"), std::string::npos) << read.error().message();
}

TEST(Image, RefusesPixelsThatWouldLieBeforeTheFile) {
    const TestFolder folder;
    const auto bmp = [](std::int32_t first_pixel) {  // of 8 x 8 pixels, 24 bits each
        const auto number = [](std::int32_t value) {
            return std::string(reinterpret_cast<const char*>(&value), sizeof value);
        };
        return "BM" + number(54 + 8 * 8 * 3) + number(0) + number(first_pixel) + number(40) + number(8) +
               number(8) + number(24 << 16 | 1) + number(0) + number(8 * 8 * 3) + std::string(16, '\0') +
               std::string(8 * 8 * 3, 'x');
    };
    ASSERT_TRUE(write_file(folder / "image.bmp", bmp(54)));
    EXPECT_TRUE(read_image(folder / "image.bmp"));
    for (const std::int32_t before : {-1, -55, -1000}) {
        ASSERT_TRUE(write_file(folder / "image.bmp", bmp(before)));
        const Result<Image> read = read_image(folder / "image.bmp");
        ASSERT_FALSE(read) << before;
        EXPECT_EQ(read.error().what.find("reader ended"), std::string::npos) << read.error().message();
    }
}

TEST(Image, AnEnvironmentIsTwiceAsWideAsHigh) {
    const TestFolder folder;
    ASSERT_TRUE(write_image(random_image(8, 4, false, 4), folder / "good.exr"));
    ASSERT_TRUE(write_image(random_image(7, 4, false, 4), folder / "bad.exr"));
    const Result<LatLongImage> good = read_environment_image(folder / "good.exr");
    ASSERT_TRUE(good);
    EXPECT_EQ(good->width, 8);
    EXPECT_EQ(good->pixels.size(), 32u);
    EXPECT_FALSE(read_environment_image(folder / "bad.exr"));
}

TEST(ClippedShare, CountsCoveredPixelsThatAreBrighterThanOne) {
    const Image image{3,
                      2,
                      {Rgb(9, 9, 9), Rgb(0.5f, 0.55f, 0.5f), Rgb(0.9f, 0.2f, 1.1f), Rgb(1, 1, 1),
                       Rgb(0.2f, 0.6f, 0.2f), Rgb(0.5f, 0.4f, 0.5f)},
                      {0.4f, 0.5f, 1, 1, 0.7f, 0.5f}};
    EXPECT_DOUBLE_EQ(clipped_share(image), 2 / 5.0);
    EXPECT_DOUBLE_EQ(clipped_share({2, 1, {Rgb(0, 2, 0), Rgb(1, 1, 1)}, {}}), 0.5);
    EXPECT_EQ(clipped_share({1, 1, {Rgb(5, 5, 5)}, {0}}), 0);
}

}  // namespace
}  // namespace haarfield
