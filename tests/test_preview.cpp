#include "bridge/pictures/preview.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/fixtures/example_meshes.h"
#include "tests/fixtures/with_threads.h"

namespace haarfield {
namespace {

Camera camera(const Vec3f& position, const Vec3f& target, int width, int height) {
    Camera result;
    result.position = position;
    result.target = target;
    result.vertical_fov = float(pi / 2);
    result.width = width;
    result.height = height;
    return result;
}

const Background black = [](const Vec3f&) { return Rgb(0.0f); };

TEST(Preview, InterpolatesRadianceOverTheTriangles) {
    // A square of side 2 in the plane y = 0, viewed from a height of 1: it fills the picture.
    const Mesh square = square_mesh(2, 0);
    std::vector<Rgb> radiance;
    for (const Vec3f& p : square.positions) radiance.emplace_back(2 + p.x, 2 + p.z, 1.0f);
    Preview preview;
    const BakedInstance instance{"", &square, {}, radiance};
    const int size = 17;
    const Image image =
        preview.draw(camera({0, 1, 0}, {0, 0, 0}, size, size), std::span(&instance, 1), black);
    ASSERT_EQ(image.pixels.size(), std::size_t(size * size));
    EXPECT_TRUE(image.coverage.empty());
    for (int row = 0; row < size; ++row)
        for (int column = 0; column < size; ++column) {
            // The view is straight down: +x is on the right, -z at the top.
            const float x = (float(column) + 0.5f) * 2 / size - 1, z = (float(row) + 0.5f) * 2 / size - 1;
            const Rgb& found = image.pixels[std::size_t(row * size + column)];
            EXPECT_NEAR(found.x, 2 + x, 0.02) << row << ", " << column;
            EXPECT_NEAR(found.y, 2 + z, 0.02) << row << ", " << column;
            EXPECT_NEAR(found.z, 1, 1e-5);
        }
}

TEST(Preview, PointsAreVisibleAtTheirPixels) {
    const Mesh square = square_mesh(2, 0, 3);
    const std::vector<BakedInstance> instances{{"", &square, {{50, 0, 0}, 1}, {}},
                                               {"", &square, {{0.2f, 0, 0}, 0.5f}, {}}};
    const int width = 14, height = 12;
    const auto points = Preview().points(camera({0, 1, 0}, {0, 0, 0}, width, height), instances);
    ASSERT_EQ(points.size(), std::size_t(width * height));
    for (int row = 0; row < height; ++row)
        for (int column = 0; column < width; ++column) {
            // The view is straight down, as above.
            const float x = (float(column) + 0.5f - 7) * 2 / height, z = (float(row) + 0.5f) * 2 / height - 1;
            const auto& point = points[std::size_t(row * width + column)];
            const bool inside = std::abs(x - 0.2f) < 0.5f && std::abs(z) < 0.5f;
            ASSERT_EQ(point.has_value(), inside) << row << ", " << column;
            if (!inside) continue;
            EXPECT_EQ(point->instance, 1u);
            Vec3f place(0.2f, 0, 0);
            for (std::size_t c = 0; c < 3; ++c)
                place +=
                    square.positions[square.triangles[point->triangle][c]] * (0.5f * point->weights()[c]);
            EXPECT_NEAR(place.x, x, 1e-5);
            EXPECT_NEAR(place.z, z, 1e-5);
        }
}

TEST(Preview, ReadsOnlyAnnouncedRadiance) {
    const Mesh square = square_mesh(1, 0, 12);
    std::vector<Rgb> radiance;  // with edges inside, too, which need further rays
    for (const Vec3f& p : square.positions) radiance.push_back(Rgb(p.x > 0.1f ? 1.0f : 0.2f, p.z, 0.5f));
    std::vector<Rgb> known(radiance.size(), Rgb(std::numeric_limits<float>::quiet_NaN()));
    const auto instances_with = [&](std::span<const Rgb> values) {
        return std::vector<BakedInstance>{{"", &square, {}, values},
                                          {"", &square, {{0.3f, 0.4f, 0.2f}, 0.5f}, radiance}};
    };
    const Camera eye = camera({0.3f, 1, 0.2f}, {0, 0, 0}, 60, 40);
    Preview preview;
    const Image whole = preview.draw(eye, instances_with(radiance), black);
    int calls = 0;
    const Image image = preview.draw(eye, instances_with(known), black, [&](const VertexMask& seen) {
        for (std::size_t v = 0; v < known.size(); ++v)
            if (seen[0][v]) known[v] = radiance[v];
        ++calls;
        return true;
    });
    EXPECT_EQ(calls, 2);
    EXPECT_EQ(image.pixels, whole.pixels);
    EXPECT_TRUE(std::any_of(known.begin(), known.end(), [](const Rgb& r) { return std::isnan(r.x); }));
    EXPECT_TRUE(preview.draw(eye, instances_with(known), black, [](auto&) { return false; }).pixels.empty());
}

TEST(Preview, PlacesAndScalesInstances) {
    const Mesh square = square_mesh(1, 0);
    const std::vector<Rgb> red(square.positions.size(), Rgb(1, 0, 0)),
        green(square.positions.size(), Rgb(0, 1, 0));
    // The second lies above the first, moved to the right half of the view.
    const std::vector<BakedInstance> instances{{"", &square, {{0, 0, 0}, 4}, red},
                                               {"", &square, {{0.5f, 0.5f, 0}, 1}, green}};
    Preview preview;
    const Image image = preview.draw(camera({0, 1, 0}, {0, 0, 0}, 40, 40), instances, black);
    const auto at = [&](int column, int row) { return image.pixels[std::size_t(row * 40 + column)]; };
    // Interpolation rounds the sum of the three weights.
    EXPECT_LT((at(10, 20) - Rgb(1, 0, 0)).length(), 1e-6);
    EXPECT_LT((at(30, 20) - Rgb(0, 1, 0)).length(), 1e-6);
    EXPECT_LT((at(39, 2) - Rgb(0, 1, 0)).length(), 1e-6);
    // From below, too: triangles emit light on both sides, as in POV-Ray.
    const Image below = preview.draw(camera({-0.2f, -1, 0}, {-0.2f, 0, 0}, 8, 8), instances, black);
    EXPECT_LT((below.pixels[36] - Rgb(1, 0, 0)).length(), 1e-6);
}

TEST(Preview, ShowsTheBackgroundWhereNothingIs) {
    Preview preview;
    const Background directions = [](const Vec3f& d) { return Rgb(d.normalized() * 0.5f + Vec3f(0.5f)); };
    const Image image = preview.draw(camera({0, 0, 0}, {0, 0, -1}, 21, 21), {}, directions);
    const Rgb centre = image.pixels[220], left = image.pixels[210], top = image.pixels[10];
    EXPECT_NEAR(centre.z, 0, 1e-5);
    EXPECT_LT(left.x, 0.2);
    EXPECT_GT(top.y, 0.8);
}

TEST(Preview, SmoothsEdgesToTheirCoverage) {
    // A half plane with an oblique edge in the picture: the mean is the covered fraction.
    const Mesh square = square_mesh(200, 0);
    const std::vector<Rgb> white(square.positions.size(), Rgb(1.0f));
    const BakedInstance instance{"", &square, {{100.03f, 0, 7}, 1}, white};
    Preview preview;
    Camera turned = camera({0, 1, 0}, {0.02f, 0, 0.05f}, 64, 64);
    const Image image = preview.draw(turned, std::span(&instance, 1), black);
    int between = 0;
    for (const Rgb& pixel : image.pixels) {
        EXPECT_NEAR(pixel.x * 8, std::round(pixel.x * 8), 1e-4);
        between += pixel.x > 0.01f && pixel.x < 0.99f;
    }
    EXPECT_GT(between, 40);
    EXPECT_LT(between, 64 * 3);
}

TEST(Preview, DoesNotDependOnTheNumberOfThreads) {
    const Mesh ball = sphere_mesh({0, 0, 0}, 0.8f, 20);
    std::vector<Rgb> radiance;
    for (const Vec3f& p : ball.positions) radiance.push_back(p * 0.5f + Vec3f(0.5f));
    const BakedInstance instance{"", &ball, {}, radiance};
    std::vector<Rgb> wanted;
    for (const std::size_t threads : {1u, 2u, 8u}) {
        Preview preview;
        const Image image = with_threads(threads, [&] {
            return preview.draw(camera({0, 1, 2}, {0, 0, 0}, 70, 50), std::span(&instance, 1), black);
        });
        if (wanted.empty()) wanted = image.pixels;
        EXPECT_EQ(image.pixels, wanted) << threads;
    }
}

}  // namespace
}  // namespace haarfield
