#include "shading/transfer/coefficient_energies.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace haarfield {
namespace {

void fill(CoefficientEnergies& energies, std::uint32_t seed, std::size_t blocks, float size) {
    std::mt19937 random(seed);
    std::exponential_distribution<float> spread(1.5f);
    energies.clear(blocks);
    for (; energies.blocks < blocks; ++energies.blocks)
        for (float& energy : energies.energy[energies.blocks]) {
            energy = size * std::exp(-6 * spread(random));
            energies.sum += double(energy);
        }
}

TEST(CoefficientEnergies, MarksTheCoefficientsToKeep) {
    for (const float size : {1e-12f, 1.0f, 1e12f})
        for (const double error : {0.3, 0.02, 1e-4}) {
            CoefficientEnergies energies;
            fill(energies, 3, 90, size);
            const double allowed = error * energies.sum;
            const std::size_t count = energies.mark(allowed);
            std::size_t marked = 0;
            double left_out = 0;
            float largest_out = 0, least_kept = INFINITY;
            for (std::size_t i = 0; i < energies.blocks; ++i)
                for (std::size_t slot = 0; slot < wide_cells; ++slot) {
                    const float energy = energies.energy[i][slot];
                    if (energies.marks[i] >> slot & 1u) {
                        ++marked;
                        least_kept = std::min(least_kept, energy);
                    } else {
                        left_out += double(energy);
                        largest_out = std::max(largest_out, energy);
                    }
                }
            EXPECT_EQ(count, marked);
            EXPECT_LE(left_out, allowed * (1 + 1e-6));
            EXPECT_LE(largest_out, least_kept);
            // With all blocks up to an eighth above the limit, the error would be too large.
            double more = left_out;
            for (std::size_t i = 0; i < energies.blocks; ++i)
                for (std::size_t slot = 0; slot < wide_cells; ++slot)
                    if ((energies.marks[i] >> slot & 1u) && energies.energy[i][slot] <= largest_out * 1.3f)
                        more += double(energies.energy[i][slot]);
            EXPECT_GT(more, allowed) << size << " " << error;
        }
}

TEST(CoefficientEnergies, MarksDoNotDependOnEarlierCalls) {
    for (const double before : {0.0, 1e-9, 0.5, 1.0}) {
        CoefficientEnergies fresh, used;
        fill(used, 11, 40, 1e5f);
        used.mark(before * used.sum);
        fill(fresh, 5, 70, 1);
        fill(used, 5, 70, 1);
        EXPECT_EQ(fresh.mark(0.01 * fresh.sum), used.mark(0.01 * used.sum));
        for (std::size_t i = 0; i < fresh.blocks; ++i) EXPECT_EQ(fresh.marks[i], used.marks[i]);
    }
}

TEST(CoefficientEnergies, MarksAllNonzeroCoefficientsIfNoErrorIsAllowed) {
    CoefficientEnergies energies;
    energies.clear(1);
    energies.energy[0] = {0, 1e-30f, 2, 0, 1};
    energies.blocks = 1;
    energies.sum = 3;
    EXPECT_EQ(energies.mark(0), 3u);
    EXPECT_EQ(energies.marks[0], 0b10110);
}

}  // namespace
}  // namespace haarfield
