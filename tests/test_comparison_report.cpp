#include "bridge/pictures/comparison_report.h"

#include "tests/fixtures/bridge_fixtures.h"

namespace haarfield {
namespace {

/// Returns an image of a shaded ball on an empty background. `error` brightens its right half.
Image ball(int width, int height, float error) {
    Image image{width, height, {}, {}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const float u =
                (2.0f * static_cast<float>(x) + 1 - static_cast<float>(width)) / static_cast<float>(height);
            const float v = (2.0f * static_cast<float>(y) + 1) / static_cast<float>(height) - 1;
            const float depth = 0.8f - u * u - v * v;
            image.coverage.push_back(depth > 0 ? 1.0f : 0.0f);
            const float light = depth > 0 ? 0.2f + std::sqrt(depth) * (u > 0 ? 1 + error : 1) : 0.0f;
            image.pixels.push_back(depth > 0 ? Rgb(0.7f, 0.4f, 0.25f) * light : Rgb(0, 0, 0));
        }
    return image;
}

std::size_t occurrences(const std::string& text, const std::string& part) {
    std::size_t count = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
    return count;
}

TEST(ComparisonReport, IsOneSelfContainedFile) {
    const TestFolder folder;
    const Image image = ball(64, 48, 0.1f), reference = ball(64, 48, 0);
    const Result<ImageDifference> difference = image_difference(image, reference);
    ASSERT_TRUE(difference);
    ComparisonReport report;
    report.title = "ball & <chain>";
    report.image = &image;
    report.reference = &reference;
    report.difference = &*difference;
    report.facts = {{"Lights", "<1024>"}};
    report.commands = {"haarfield bake \"a & b.toml\"", "haarfield reference x"};
    ASSERT_TRUE(write_comparison_report(report, folder / "report.html"));
    EXPECT_EQ(folder.files(), (std::vector<std::string>{"report.html"}));
    const std::string text = text_of(folder / "report.html");
    EXPECT_EQ(occurrences(text, "src=\"data:image/png;base64,"), 3u);
    EXPECT_EQ(occurrences(text, "http"), 0u) << "the report loads nothing from the network";
    EXPECT_EQ(occurrences(text, "ball &amp; &lt;chain&gt;"), 2u);
    EXPECT_EQ(occurrences(text, "&lt;1024&gt;"), 1u);
    EXPECT_EQ(occurrences(text, "haarfield bake &quot;a &amp; b.toml&quot;"), 1u);
    EXPECT_GT(occurrences(text, "<rect "), 1u);
    EXPECT_EQ(occurrences(text, "nan"), 0u);
}

TEST(ComparisonReport, EmbedsThePicturesUnchanged) {
    const TestFolder folder;
    for (int width : {5, 6, 7}) {  // all paddings of base64
        const Image image = ball(width, 4, 0);
        const Result<ImageDifference> difference = image_difference(image, image);
        ASSERT_TRUE(difference);
        ComparisonReport report;
        report.image = report.reference = &image;
        report.difference = &*difference;
        ASSERT_TRUE(write_comparison_report(report, folder / "report.html"));
        const std::string text = text_of(folder / "report.html");
        const std::size_t begin = text.find("base64,") + 7, end = text.find('"', begin);
        std::string bytes;
        std::uint32_t bits = 0;
        int held = 0;
        for (char c : text.substr(begin, end - begin)) {
            const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
            if (c == '=') break;
            bits = bits << 6 | static_cast<std::uint32_t>(digits.find(c));
            if ((held += 6) >= 8) bytes += static_cast<char>(bits >> (held -= 8) & 255u);
        }
        const Result<std::string> expected = png_bytes(image);
        ASSERT_TRUE(expected);
        EXPECT_EQ(bytes, *expected);
    }
}

TEST(ComparisonReport, RefusesPicturesOfOtherSizes) {
    const TestFolder folder;
    const Image image = ball(8, 8, 0), other = ball(8, 9, 0);
    const Result<ImageDifference> difference = image_difference(image, image);
    ASSERT_TRUE(difference);
    ComparisonReport report;
    report.image = &image;
    report.reference = &other;
    report.difference = &*difference;
    EXPECT_FALSE(write_comparison_report(report, folder / "report.html"));
    EXPECT_TRUE(folder.files().empty());
}

}  // namespace
}  // namespace haarfield
