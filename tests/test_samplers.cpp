#include "fields/field/samplers.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/fixtures/random_numbers.h"

namespace haarfield {
namespace {

/// Interpolates a function between its values at the samples.
template <class Sampler, class Function>
double interpolated(const Sampler& sampler, const Vec3f& position, Function f) {
    const Interpolation weights = sampler.interpolation(position);
    double value = weights.open;
    for (int i = 0; i < weights.count; ++i)
        value += weights.weight[std::size_t(i)] * f(sampler.sample_position(weights.sample[std::size_t(i)]));
    return value;
}

/// A smooth function that is 1 far away and depends on the direction.
double example(const Vec3f& p) {
    const double r2 = p.dot(p);
    return 1 -
           std::exp(-r2 / 8) * (0.5 + 0.2 * std::sin(2 * p.x + 0.3) * std::cos(p.z) + 0.1 * std::sin(p.y));
}

template <class Sampler>
void expect_exact_at_samples(const Sampler& sampler) {
    for (std::uint32_t s = 0; s < sampler.sample_count(); ++s) {
        const Vec3f p = sampler.sample_position(s);
        const Interpolation weights = sampler.interpolation(p);
        double here = 0;
        for (int i = 0; i < weights.count; ++i)
            if ((sampler.sample_position(weights.sample[std::size_t(i)]) - p).length() < 1e-5f)
                here += weights.weight[std::size_t(i)];
        EXPECT_NEAR(here, 1, 2e-3) << "sample " << s;
    }
}

template <class Sampler>
void expect_weights_add_up(const Sampler& sampler, float height) {
    std::mt19937 random(5);
    const auto place = [&] { return uniform(random, -12.0f, 12.0f); };
    for (int i = 0; i < 3000; ++i) {
        const Interpolation weights = sampler.interpolation(Vec3f{place(), height * place(), place()});
        double sum = weights.open;
        for (int k = 0; k < weights.count; ++k) {
            EXPECT_GT(weights.weight[std::size_t(k)], 0);
            EXPECT_LT(weights.sample[std::size_t(k)], sampler.sample_count());
            sum += weights.weight[std::size_t(k)];
        }
        EXPECT_NEAR(sum, 1, 1e-5);
    }
}

/// Follows a path in tiny steps: consecutive values must be close to each other.
template <class Sampler, class Path>
void expect_continuous(const Sampler& sampler, Path path, double tolerance) {
    const int steps = 4000;
    double before = interpolated(sampler, path(0.0), example);
    for (int i = 1; i <= steps; ++i) {
        const double now = interpolated(sampler, path(double(i) / steps), example);
        EXPECT_NEAR(now, before, tolerance) << "step " << i;
        before = now;
    }
}

Vec3f circle(double t, double radius, double height) {
    return {float(radius * std::cos(2 * pi * t)), float(height), float(radius * std::sin(2 * pi * t))};
}

TEST(PlanarSampler, IsExactAtItsSamples) {
    expect_exact_at_samples(planar_sampler({0, 0, 0}, 1, 2000));
}
TEST(SphericalSampler, IsExactAtItsSamples) {
    expect_exact_at_samples(spherical_sampler({0, 0, 0}, 1, 2000));
}
TEST(PlanarSampler, WeightsAddUpToOne) {
    expect_weights_add_up(planar_sampler({0, 0, 0}, 1, 2000), 0);
}
TEST(SphericalSampler, WeightsAddUpToOne) {
    expect_weights_add_up(spherical_sampler({0, 0, 0}, 1, 2000), 1);
}

TEST(PlanarSampler, IsContinuousAcrossWrapCentreAndTheOuterRadius) {
    const PlanarSampler sampler = planar_sampler({0, 0, 0}, 1, 2000);
    expect_continuous(
        sampler, [](double t) { return circle(t - 0.5, 2, 0); }, 2e-3);
    expect_continuous(
        sampler, [](double t) { return Vec3f(float(4 * t - 2), 0, 0.001f); }, 4e-3);
    expect_continuous(
        sampler, [](double t) { return Vec3f(float(5 + 5 * t), 0, 1); }, 2e-3);
}

TEST(SphericalSampler, IsContinuousAcrossWrapPolesCentreAndTheOuterRadius) {
    const SphericalSampler sampler = spherical_sampler({0, 0, 0}, 1, 4000);
    expect_continuous(
        sampler, [](double t) { return circle(t - 0.5, 2, 0.5); }, 2e-3);
    // Across both poles.
    expect_continuous(
        sampler, [](double t) { return Vec3f(float(2 * t - 1), 2, 0.001f); }, 3e-3);
    expect_continuous(
        sampler, [](double t) { return Vec3f(float(2 * t - 1), -2, 0.001f); }, 3e-3);
    expect_continuous(
        sampler, [](double t) { return Vec3f(float(4 * t - 2), 0.001f, 0.001f); }, 6e-3);
    expect_continuous(
        sampler, [](double t) { return Vec3f(float(5 + 5 * t), 1, 1); }, 2e-3);
}

TEST(SphericalSampler, PolesOfAShellAreOnePlaceForAllAzimuths) {
    const SphericalSampler sampler = spherical_sampler({1, 2, 3}, 1, 3000);
    const auto azimuths = static_cast<std::uint32_t>(sampler.azimuths),
               polar = static_cast<std::uint32_t>(sampler.polar);
    for (std::uint32_t a = 1; a < azimuths; ++a) {
        EXPECT_EQ(sampler.sample_position(polar * azimuths + a), sampler.sample_position(polar * azimuths));
        EXPECT_EQ(sampler.sample_position((2 * polar - 1) * azimuths + a),
                  sampler.sample_position((2 * polar - 1) * azimuths));
    }
    EXPECT_GT(sampler.sample_position(polar * azimuths).y, 2);
}

TEST(Samplers, BeyondTheOuterRadiusWeightsFallWithTheSquareOfTheDistance) {
    const PlanarSampler planar = planar_sampler({0, 0, 0}, 1, 2000);
    const SphericalSampler spherical = spherical_sampler({0, 0, 0}, 1, 2000);
    EXPECT_EQ(planar.interpolation({5.9f, 0, 0}).open, 0);
    EXPECT_EQ(spherical.interpolation({0, 5.9f, 0}).open, 0);
    for (const float distance : {6.5f, 12.0f, 300.0f}) {
        const float wanted = 1 - 36 / (distance * distance);
        EXPECT_NEAR(planar.interpolation({distance, 0, 0}).open, wanted, 1e-6);
        EXPECT_NEAR(spherical.interpolation({0, distance, 0}).open, wanted, 1e-6);
    }
}

TEST(Samplers, HaveNoMoreSamplesThanWantedAndNotMuchFewer) {
    for (const std::uint32_t wanted : {100u, 1000u, 10000u, 20000u, 62000u}) {
        EXPECT_LE(planar_sampler({0, 0, 0}, 1, wanted).sample_count(), wanted);
        EXPECT_GE(planar_sampler({0, 0, 0}, 1, wanted).sample_count(), wanted * 8 / 10);
        EXPECT_LE(spherical_sampler({0, 0, 0}, 1, wanted).sample_count(), wanted);
        EXPECT_GE(spherical_sampler({0, 0, 0}, 1, wanted).sample_count(), wanted * 6 / 10);
    }
}

TEST(Samplers, SpacingGrowsWithDistance) {
    const PlanarSampler sampler = planar_sampler({0, 0, 0}, 1, 20000);
    float before = 0, spacing = 0;
    for (int ring = 1; ring < sampler.rings; ++ring) {
        const float radius = sampler.sample_position(static_cast<std::uint32_t>(ring * sampler.angles)).x;
        EXPECT_GT(radius - before, spacing * 0.999f);
        spacing = radius - before;
        before = radius;
    }
    EXPECT_NEAR(before, 6, 1e-4);
}

}  // namespace
}  // namespace haarfield
