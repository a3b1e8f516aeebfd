#include "shading/scene/lobes.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/fixtures/random_numbers.h"

namespace haarfield {
namespace {

std::vector<Vec3f> random_directions(int count) {
    std::mt19937 random(3);
    std::vector<Vec3f> directions;
    while (int(directions.size()) < count) directions.push_back(random_direction(random));
    return directions;
}

/// Returns int f dw over the sphere, from texels. [sr]
double sphere_integral(const std::vector<float>& texels, int size) {
    double sum = 0;
    std::size_t i = 0;
    for (int face = 0; face < 6; ++face)
        for (int row = 0; row < size; ++row)
            for (int column = 0; column < size; ++column)
                sum += texels[i++] * texel_solid_angle(column, row, size);
    return sum;
}

TEST(Lobes, TexelsIntegrateToTheClosedForm) {
    // int max(0, d.w)^n dw = 2 pi / (n + 1)
    for (const float exponent : {1.0f, 5.0f, 60.0f, 200.0f, 1000.0f})
        for (const Vec3f& d : random_directions(5))
            EXPECT_NEAR(sphere_integral(lobe_texels(exponent, d, 64), 64) * (exponent + 1) / (2 * pi), 1,
                        0.01)
                << exponent << " " << d;
}

}  // namespace
}  // namespace haarfield
