#include "shading/scene/lobes.h"
#include "shading/walk/brdf.h"

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

/// The variance of the directions of a cap of half angle a is (1 - cos a) / 2.
TEST(Lobes, MeanOverACapIsThatOfItsDirections) {
    constexpr int rings = 40, sectors = 80;
    const Vec3f normal(0, 1, 0);
    for (const double view : {0.0, 0.5, 1.0})
        for (const LobeAxis axis : {LobeAxis::mirror, LobeAxis::half_vector})
            for (const float exponent : {0.0f, 4.0f, 30.0f, 100.0f})
                for (const double aside : {0.0, 0.1, 0.3}) {
                    VertexBrdf brdf;
                    brdf.normal = normal;
                    brdf.mirror = Vec3f(float(std::sin(view)), float(std::cos(view)), 0);
                    const Lobe lobe{axis, 1, exponent};
                    const Vec3f middle = (brdf.mirror + Vec3f(0, 0, float(aside))).normalized();
                    const Axes<Vec3f> axes = axes_across(middle);
                    const double angle = 0.05;
                    double sum = 0;
                    for (int r = 0; r < rings; ++r)
                        for (int s = 0; s < sectors; ++s) {
                            const double cosine = 1 - (r + 0.5) / rings * (1 - std::cos(angle)),
                                         sine = std::sqrt(1 - cosine * cosine), turn = 2 * pi * s / sectors;
                            sum += double(lobe_value(lobe, brdf,
                                                     middle * float(cosine) +
                                                         axes.across * float(sine * std::cos(turn)) +
                                                         axes.up * float(sine * std::sin(turn))));
                        }
                    EXPECT_NEAR(lobe_value(lobe, brdf, middle, float((1 - std::cos(angle)) / 2)),
                                sum / (rings * sectors), 0.002)
                        << "exponent " << exponent << ", view " << view << ", aside " << aside
                        << (axis == LobeAxis::mirror ? ", R" : ", H");
                }
}

}  // namespace
}  // namespace haarfield
