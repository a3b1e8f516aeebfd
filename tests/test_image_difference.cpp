#include "bridge/pictures/image_difference.h"

#include "bridge/pictures/perceptual_error.h"

#include <gtest/gtest.h>

#include <random>

namespace haarfield {
namespace {

Image constant_image(int width, int height, const Rgb& radiance) {
    Image image{width, height, {}, {}};
    image.pixels.assign(static_cast<std::size_t>(width * height), radiance);
    return image;
}

Image random_image(int width, int height, unsigned seed) {
    std::mt19937 random(seed);
    Image image = constant_image(width, height, Rgb(0, 0, 0));
    for (Rgb& pixel : image.pixels)
        for (int c = 0; c < 3; ++c) pixel[c] = static_cast<float>(random()) / 4294967296.0f;
    return image;
}

TEST(ImageDifference, OfEqualImagesIsNone) {
    const Image image = random_image(31, 17, 1);
    const Result<ImageDifference> difference = image_difference(image, image);
    ASSERT_TRUE(difference);
    EXPECT_EQ(difference->pixels, 31u * 17u);
    EXPECT_EQ(difference->rmse, 0);
    EXPECT_EQ(difference->relative_rmse, 0);
    EXPECT_EQ(difference->psnr_db, 99);
    EXPECT_NEAR(difference->ssim, 1, 1e-9);
    EXPECT_EQ(difference->flip, 0);
}

TEST(ImageDifference, RadianceErrorsAreLinearAndUnclamped) {
    const Image image = constant_image(8, 8, Rgb(11, 4, 2)), reference = constant_image(8, 8, Rgb(10, 4, 2));
    const Result<ImageDifference> difference = image_difference(image, reference);
    ASSERT_TRUE(difference);
    EXPECT_NEAR(difference->rmse, std::sqrt(1.0 / 3), 1e-9);
    EXPECT_NEAR(difference->relative_rmse, std::sqrt(1.0 / 120), 1e-9);
    EXPECT_NEAR(difference->bias, 1.0 / 16, 1e-9);
    EXPECT_EQ(difference->psnr_db, 99) << "everything is clipped to white";
}

TEST(ImageDifference, PsnrIsThatOfSrgbValues) {
    // A difference of 0.1 in sRGB everywhere is 20 dB at all linear levels.
    for (float low : {0.1f, 0.5f, 0.8f}) {
        const Image reference = constant_image(8, 8, Rgb(1, 1, 1) * srgb_decoded(low));
        const Image image = constant_image(8, 8, Rgb(1, 1, 1) * srgb_decoded(low + 0.1f));
        const Result<ImageDifference> difference = image_difference(image, reference);
        ASSERT_TRUE(difference);
        EXPECT_NEAR(difference->psnr_db, 20, 1e-3) << low;
    }
}

TEST(ImageDifference, SsimOfConstantPicturesIsThatOfTheirMeans) {
    const Image image = constant_image(16, 16, Rgb(1, 1, 1) * srgb_decoded(0.5f));
    const Image reference = constant_image(16, 16, Rgb(1, 1, 1) * srgb_decoded(0.75f));
    const Result<ImageDifference> difference = image_difference(image, reference);
    ASSERT_TRUE(difference);
    EXPECT_NEAR(difference->ssim, (2 * 0.5 * 0.75 + 1e-4) / (0.25 + 0.5625 + 1e-4), 1e-5);
}

TEST(ImageDifference, SsimEqualsTheSumOverTheWindow) {
    const int width = 14, height = 12;
    const Image image = random_image(width, height, 2), reference = random_image(width, height, 3);
    std::vector<float> x, y;
    std::vector<std::uint8_t> mask;
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        x.push_back(image.pixels[i].x);
        y.push_back(reference.pixels[i].x);
        mask.push_back(i % 7 != 0);
    }
    double expected = 0, count = 0;
    for (int row = 0; row < height; ++row)
        for (int column = 0; column < width; ++column) {
            if (!mask[static_cast<std::size_t>(row * width + column)]) continue;
            double w = 0, sx = 0, sy = 0, sxx = 0, syy = 0, sxy = 0;
            for (int j = std::max(0, row - 5); j <= std::min(height - 1, row + 5); ++j)
                for (int i = std::max(0, column - 5); i <= std::min(width - 1, column + 5); ++i) {
                    const std::size_t k = static_cast<std::size_t>(j * width + i);
                    if (!mask[k]) continue;
                    const double weight =
                        std::exp(-((i - column) * (i - column) + (j - row) * (j - row)) / 4.5);
                    w += weight;
                    sx += weight * x[k];
                    sy += weight * y[k];
                    sxx += weight * x[k] * x[k];
                    syy += weight * y[k] * y[k];
                    sxy += weight * x[k] * y[k];
                }
            const double mx = sx / w, my = sy / w;
            expected += (2 * mx * my + 1e-4) * (2 * (sxy / w - mx * my) + 9e-4) /
                        ((mx * mx + my * my + 1e-4) * (sxx / w - mx * mx + syy / w - my * my + 9e-4));
            ++count;
        }
    EXPECT_NEAR(structural_similarity(x, y, mask, width, height), expected / count, 1e-9);
}

TEST(ImageDifference, FlipOfBlackAgainstWhiteIsOne) {
    // Lightness 100 against 0, on a scale that ends at the distance between pure green and pure blue.
    const Result<ImageDifference> difference =
        image_difference(constant_image(32, 32, Rgb(1, 1, 1)), constant_image(32, 32, Rgb(0, 0, 0)));
    ASSERT_TRUE(difference);
    EXPECT_GT(difference->flip, 0.95);
    EXPECT_LE(difference->flip, 1.0);
    const Result<ImageDifference> farthest =
        image_difference(constant_image(32, 32, Rgb(0, 1, 0)), constant_image(32, 32, Rgb(0, 0, 1)));
    ASSERT_TRUE(farthest);
    EXPECT_NEAR(farthest->flip, 1.0, 1e-3);
}

TEST(ImageDifference, FlipIsSymmetricAndGrowsWithTheDifference) {
    const Image reference = random_image(24, 24, 5);
    double before = 0;
    for (float offset : {0.01f, 0.03f, 0.1f, 0.3f}) {
        Image image = reference;
        for (Rgb& pixel : image.pixels) pixel = pixel * (1 - offset);
        const Result<ImageDifference> there = image_difference(image, reference);
        const Result<ImageDifference> back = image_difference(reference, image);
        ASSERT_TRUE(there && back);
        EXPECT_NEAR(there->flip, back->flip, 1e-9);
        EXPECT_GT(there->flip, before);
        before = there->flip;
    }
}

TEST(ImageDifference, FlipForgivesNoiseThatTheEyeAverages) {
    // A checkerboard of single pixels appears grey from the viewing distance, one of 16 pixels does not.
    const auto checkerboard = [](int size) {
        Image image = constant_image(64, 64, Rgb(0, 0, 0));
        for (int y = 0; y < 64; ++y)
            for (int x = 0; x < 64; ++x)
                if ((x / size + y / size) % 2)
                    image.pixels[static_cast<std::size_t>(64 * y + x)] = Rgb(0.4f, 0.4f, 0.4f);
        return image;
    };
    const Image grey = constant_image(64, 64, Rgb(0.2f, 0.2f, 0.2f));
    const Result<ImageDifference> fine = image_difference(checkerboard(1), grey);
    const Result<ImageDifference> coarse = image_difference(checkerboard(16), grey);
    ASSERT_TRUE(fine && coarse);
    EXPECT_LT(fine->flip, 0.05);
    EXPECT_GT(coarse->flip, 0.25);
}

TEST(ImageDifference, CountsOnlyPixelsThatBothImagesAndTheMaskCover) {
    Image image = constant_image(4, 1, Rgb(1, 1, 1)), reference = constant_image(4, 1, Rgb(1, 1, 1));
    image.coverage = {1, 1, 0.4f, 1};
    reference.coverage = {1, 0, 1, 1};
    image.pixels[1] = image.pixels[2] = image.pixels[3] = Rgb(9, 9, 9);
    ImageDifferenceOptions options;
    options.mask = constant_image(4, 1, Rgb(1, 1, 1));
    options.mask.pixels[3] = Rgb(0, 0, 0);
    const Result<ImageDifference> difference = image_difference(image, reference, options);
    ASSERT_TRUE(difference);
    EXPECT_EQ(difference->pixels, 1u);
    EXPECT_EQ(difference->rmse, 0);
    EXPECT_EQ(difference->flip, 0);
    EXPECT_EQ(difference->mask, (std::vector<std::uint8_t>{1, 0, 0, 0}));
    const Result<ImageDifference> without_mask = image_difference(image, reference);
    ASSERT_TRUE(without_mask);
    EXPECT_EQ(without_mask->pixels, 2u);
    EXPECT_NEAR(without_mask->rmse, std::sqrt(32.0), 1e-9);
}

TEST(ImageDifference, RefusesIncomparableImages) {
    const Image image = constant_image(4, 2, Rgb(1, 1, 1));
    EXPECT_FALSE(image_difference(image, constant_image(2, 4, Rgb(1, 1, 1))));
    ImageDifferenceOptions options;
    options.mask = constant_image(3, 2, Rgb(1, 1, 1));
    EXPECT_FALSE(image_difference(image, image, options));
    options.mask = constant_image(4, 2, Rgb(0, 0, 0));
    EXPECT_FALSE(image_difference(image, image, options));
    for (float bad : {NAN, INFINITY}) {
        Image broken = image;
        broken.pixels[5].z = bad;
        EXPECT_FALSE(image_difference(broken, image));
        EXPECT_FALSE(image_difference(image, broken));
    }
}

TEST(ErrorColour, GrowsEvenlyInLightness) {
    const auto lightness = [](float error) {
        Rgb linear;
        const auto colour = error_colour(error);
        for (int c = 0; c < 3; ++c)
            linear[c] = srgb_decoded(static_cast<float>(colour[static_cast<std::size_t>(c)]) / 255.0f);
        return 116 * std::cbrt(luminance(linear)) - 16;
    };
    for (int i = 0; i < 20; ++i) {
        const float step = lightness(static_cast<float>(i + 1) / 20) - lightness(static_cast<float>(i) / 20);
        EXPECT_GT(step, 2) << i;
        EXPECT_LT(step, 9) << i;
    }
    EXPECT_LT(lightness(0), 12);
    EXPECT_GT(lightness(1), 88);
    EXPECT_EQ(error_colour(NAN), error_colour(0));
}

TEST(ErrorHistogram, CountsEveryPixelOnce) {
    const Image image = random_image(20, 20, 6);
    Image reference = random_image(20, 20, 7);
    reference.coverage.assign(400, 1.0f);
    reference.coverage[3] = 0;
    const Result<ImageDifference> difference = image_difference(image, reference);
    ASSERT_TRUE(difference);
    for (float upper : {0.05f, 0.5f, 1.0f}) {
        std::uint64_t sum = 0;
        for (std::uint64_t count : error_histogram(*difference, 32, upper)) sum += count;
        EXPECT_EQ(sum, 399u);
    }
}

}  // namespace
}  // namespace haarfield
