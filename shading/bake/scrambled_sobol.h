#pragma once
/// Scrambled low-discrepancy points for Monte Carlo integration.

#include <array>
#include <cstdint>
#include <vector>

#include "fields/base/vector.h"

namespace haarfield {

/// Returns a hash of two numbers.
std::uint32_t mixed_seed(std::uint32_t seed, std::uint32_t number);

/// Sobol's sequence in the unit square, with a nested uniform (Owen) scramble. The first 2^m points keep the
/// stratification of sobol_point, and each point is uniformly distributed over the seeds.
///
/// source  Laine and Karras 2011, the hash; Burley 2020, its use as a scramble.
class ScrambledSobol {
public:
    /// Different seeds give independent scrambles.
    explicit ScrambledSobol(std::uint32_t seed)
        : seeds_{mixed_seed(seed, 0x51633e2d), mixed_seed(seed, 0x68bc21eb)} {}

    /// Returns coordinates in [0, 1), of 32 bits.
    std::array<double, 2> operator()(std::uint32_t index) const;

private:
    std::array<std::uint32_t, 2> seeds_;
};

/// Rounds a point of the unit square. Coordinates stay below 1.
Vec2f as_place(const std::array<double, 2>& point);

/// Returns the first points of a sequence, ordered along a Z-curve: neighbours in the order are mostly near
/// each other, so that their rays form coherent packets.
std::vector<std::array<double, 2>> sorted_points(const ScrambledSobol& points, std::uint32_t count);

/// Permutes the 32-bit numbers. Each aligned run of 2^m numbers is mapped to an aligned run, so that points
/// of a sequence taken in this order are as evenly spread as before.
///
/// source  Burley 2020, to combine two-dimensional sequences without correlation.
std::uint32_t shuffled(std::uint32_t index, std::uint32_t seed);

}  // namespace haarfield
