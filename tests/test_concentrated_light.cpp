#include "shading/transfer/concentrated_light.h"

#include <gtest/gtest.h>

#include "fields/base/rotation.h"
#include "fields/wavelets/haar_transform.h"

namespace haarfield {
namespace {

constexpr int size = 64, cells = 16;  ///< Along an edge of a face.

Vec3d direction(std::size_t texel) {
    const auto face = int(texel) / (size * size), row = int(texel) / size % size, column = int(texel) % size;
    return cubemap_direction<Vec3d>(face, (2 * column + 1.0) / size - 1, (2 * row + 1.0) / size - 1)
        .normalized();
}

/// Returns the cell of a texel.
std::size_t cell_of(std::size_t texel) {
    const std::size_t row = texel / size % size, column = texel % size, side = size / cells;
    return (texel / (size * size) * cells + row / side) * cells + column / side;
}

/// A grey sky with suns of one texel each.
struct Sky {
    std::vector<Rgb> texels = std::vector<Rgb>(cubemap_faces * size * size, Rgb(0.3f, 0.4f, 0.5f));

    void add_sun(const Vec3d& towards, const Rgb& light) {
        std::size_t nearest = 0;
        for (std::size_t i = 0; i < texels.size(); ++i)
            if (direction(i).dot(towards) > direction(nearest).dot(towards)) nearest = i;
        texels[nearest] += light;
    }
    DenseCoefficients coefficients() const {
        return dense_coefficients(haar_cubemap<Rgb>(texels, size), size);
    }
    std::vector<ConcentratedLight> sources(float error = 1e-3f) const {
        return concentrated_light(coefficients(), direction_coefficients(size), error);
    }
    /// Returns the unoccluded irradiance, with the cosine of each texel.
    Vec3d irradiance(const Vec3d& normal) const {
        Vec3d sum(0.0);
        for (std::size_t i = 0; i < texels.size(); ++i)
            sum += Vec3d(texels[i]) * (std::max(0.0, direction(i).dot(normal)) / (size * size));
        return sum;
    }
};

/// Returns max(0, N.w), averaged over each cell, times the visible fraction.
std::vector<float> held_cosines(const Vec3d& normal, double seen) {
    std::vector<double> sums(cubemap_faces * cells * cells, 0.0);
    std::vector<float> texels(cubemap_faces * size * size);
    for (std::size_t i = 0; i < texels.size(); ++i)
        sums[cell_of(i)] += seen * std::max(0.0, direction(i).dot(normal)) * cells * cells / (size * size);
    for (std::size_t i = 0; i < texels.size(); ++i) texels[i] = float(sums[cell_of(i)]);
    return texels;
}

Vec3d inner_product(std::span<const float> texels, const SelectedCoefficients& f) {
    std::vector<Rgb> grey;
    for (const float texel : texels) grey.emplace_back(texel);
    const DenseCoefficients vector = dense_coefficients(haar_cubemap<Rgb>(grey, size), size);
    Vec3d sum(0.0);
    for (std::size_t k = 0; k < f.index.size(); ++k)
        for (std::size_t axis = 0; axis < 3; ++axis)
            sum[int(axis)] += double(f.value[k][axis]) * double(vector.values[f.index[k]][0]);
    return sum;
}

TEST(ConcentratedLight, IsTheErrorOfCosinesThatAreConstantOverCells) {
    double largest_without = 0;
    for (int trial = 0; trial < 12; ++trial) {
        const Rotation turn = rotation_about({1, 2, -1}, 0.5 * trial);
        Sky sky;
        sky.add_sun(turn(Vec3d(0, 1, 0)), Rgb(4000, 3000, 2000));
        sky.add_sun(turn(Vec3d(0, 1, 0.04).normalized()), Rgb(2000, 1500, 1000));
        const Vec3d normal = turn(Vec3d(0.5, 0.8, -0.3).normalized());
        const double seen = 0.4;
        const std::vector<float> held = held_cosines(normal, seen);
        Vec3d found(0.0);
        for (std::size_t i = 0; i < held.size(); ++i)
            found += Vec3d(sky.texels[i]) * (double(held[i]) / (size * size));
        const Vec3d wanted = sky.irradiance(normal) * seen, without = found;
        for (const ConcentratedLight& source : sky.sources()) {
            EXPECT_GT(Vec3d(source.direction).dot(turn(Vec3d(0, 1, 0))), 0.99);
            found += Vec3d(source.colour) *
                     (normal.dot(inner_product(held, source.moments)) / normal.dot(Vec3d(source.direction)));
        }
        EXPECT_LT((found - wanted).length(), 1e-3 * wanted.length()) << trial;
        largest_without = std::max(largest_without, (without - wanted).length() / wanted.length());
    }
    EXPECT_GT(largest_without, 5e-3);
}

TEST(ConcentratedLight, IsEmptyForUniformLight) {
    EXPECT_TRUE(Sky().sources().empty());
    constexpr int small = 16;  // cells are texels
    std::vector<Rgb> texels(cubemap_faces * small * small, Rgb(0.1f));
    texels[700] = Rgb(100.0f);
    EXPECT_TRUE(concentrated_light(dense_coefficients(haar_cubemap<Rgb>(texels, small), small),
                                   direction_coefficients(small), 1e-3f)
                    .empty());
}

TEST(ConcentratedLight, OfManySunsIsTheLargest) {
    Sky sky;
    for (int i = 1; i <= 6; ++i)
        sky.add_sun(rotation_about({0, 0, 1}, 0.9 * i)(Vec3d(1, 0.05, 0.01)), Rgb(float(10 * i)));
    const std::vector<ConcentratedLight> sources = sky.sources();
    ASSERT_EQ(sources.size(), 2u);
    for (int i = 0; i < 2; ++i) {
        const auto has_it = [&](const ConcentratedLight& source) {
            return Vec3d(source.direction)
                       .dot(rotation_about({0, 0, 1}, 0.9 * (6 - i))(Vec3d(1, 0.05, 0.01))) > 0.99;
        };
        EXPECT_TRUE(std::ranges::any_of(sources, has_it)) << i;
    }
    EXPECT_TRUE(sky.sources(0.9f).empty());
}

}  // namespace
}  // namespace haarfield
