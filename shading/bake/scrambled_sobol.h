#pragma once
/// Scrambled low-discrepancy points for Monte Carlo integration.

#include <array>
#include <cstdint>

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

}  // namespace haarfield
