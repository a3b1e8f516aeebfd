#include "shading/bake/scrambled_sobol.h"

#include <algorithm>

#include "shading/bounces/cosine_directions.h"

namespace haarfield {
namespace {

std::uint32_t reversed_bits(std::uint32_t x) {
    x = (x & 0x55555555u) << 1 | (x >> 1 & 0x55555555u);
    x = (x & 0x33333333u) << 2 | (x >> 2 & 0x33333333u);
    x = (x & 0x0f0f0f0fu) << 4 | (x >> 4 & 0x0f0f0f0fu);
    return __builtin_bswap32(x);
}

/// Flips each bit depending on the bits above it and on the seed.
std::uint32_t owen_scrambled(std::uint32_t x, std::uint32_t seed) {
    x = reversed_bits(x);
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return reversed_bits(x);
}

/// Returns the upper 16 bits of a number with a zero in front of each.
std::uint32_t spread_bits(std::uint32_t x) {
    x >>= 16;
    x = (x | x << 8) & 0x00ff00ffu;
    x = (x | x << 4) & 0x0f0f0f0fu;
    x = (x | x << 2) & 0x33333333u;
    return (x | x << 1) & 0x55555555u;
}

}  // namespace

std::uint32_t mixed_seed(std::uint32_t seed, std::uint32_t number) {
    std::uint32_t x = seed * 0x9e3779b9u ^ (number + 0x7f4a7c15u);
    for (int round = 0; round < 2; ++round) {
        x ^= x >> 16;
        x *= 0x7feb352du;
        x ^= x >> 15;
        x *= 0x846ca68bu;
        x ^= x >> 16;
        x += number;
    }
    return x;
}

std::array<double, 2> ScrambledSobol::operator()(std::uint32_t index) const {
    const std::array<std::uint32_t, 2> digits = sobol_digits(index);
    constexpr double unit = 1.0 / 4294967296.0;
    return {owen_scrambled(digits[0], seeds_[0]) * unit, owen_scrambled(digits[1], seeds_[1]) * unit};
}

Vec2f as_place(const std::array<double, 2>& point) {
    constexpr float below_one = 0.99999994f;
    return Vec2f(std::min(float(point[0]), below_one), std::min(float(point[1]), below_one));
}

std::vector<std::array<double, 2>> sorted_points(const ScrambledSobol& points, std::uint32_t count) {
    struct Place {
        std::uint32_t code;
        std::array<double, 2> point;
    };
    std::vector<Place> places(count);
    constexpr double range = 4294967296.0;
    for (std::uint32_t i = 0; i < count; ++i) {
        const std::array<double, 2> point = points(i);
        places[i] = {
            spread_bits(std::uint32_t(point[0] * range)) | spread_bits(std::uint32_t(point[1] * range)) << 1,
            point};
    }
    std::ranges::stable_sort(places, {}, &Place::code);
    std::vector<std::array<double, 2>> sorted;
    sorted.reserve(count);
    for (const Place& place : places) sorted.push_back(place.point);
    return sorted;
}

std::uint32_t shuffled(std::uint32_t index, std::uint32_t seed) {
    return owen_scrambled(index, seed);
}

}  // namespace haarfield
