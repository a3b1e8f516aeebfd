#include "shading/transfer/coefficient_energies.h"

#include <algorithm>
#include <bit>
#include <cmath>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shading/transfer/coefficient_energies.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "shading/walk/cells-inl.h"

HWY_BEFORE_NAMESPACE();
namespace haarfield {
namespace HWY_NAMESPACE {

/// Returns the sum of the energies up to a limit.
float energy_below(const CoefficientEnergies& energies, float limit) {
    // Two sums, so that additions need not wait for each other.
    Cells even = all_cells(0), odd = even;
    std::size_t i = 0;
    for (; i + 2 <= energies.blocks; i += 2) {
        even = even + only_up_to(limit, load_cells(energies.energy[i].data()));
        odd = odd + only_up_to(limit, load_cells(energies.energy[i + 1].data()));
    }
    if (i < energies.blocks) even = even + only_up_to(limit, load_cells(energies.energy[i].data()));
    return sum_of(even + odd);
}

/// Marks the cells with energies above a limit, and returns their number.
std::size_t mark_above(CoefficientEnergies& energies, float limit) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < energies.blocks; ++i) {
        const unsigned marks = cells_above(load_cells(energies.energy[i].data()), limit);
        energies.marks[i] = static_cast<std::uint16_t>(marks);
        count += std::size_t(std::popcount(marks));
    }
    return count;
}

}  // namespace HWY_NAMESPACE
}  // namespace haarfield
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace haarfield {

HWY_EXPORT(energy_below);
HWY_EXPORT(mark_above);

EnergyWeights::EnergyWeights(const CoefficientSpectrum& spectrum) {
    for (int level = 0; level < 4; ++level)
        for (std::size_t slot = 0; slot < wide_cells; ++slot) {
            const float of_amplitude = coefficient_of_amplitude(level, slot),
                        matters = of_amplitude * spectrum[spectrum_place(level, slot)];
            normalisation[std::size_t(level)][slot] = of_amplitude;
            weight[std::size_t(level)][slot] = matters * matters;
        }
}

DetailWeights detail_weights(const CoefficientSpectrum& spectrum, double energy_of_a_cell) {
    DetailWeights detail;
    for (std::size_t level = 0; level < detail.weight.size(); ++level) {
        const std::size_t below =
            std::min(spectrum_place(static_cast<int>(level) + 1, 4), spectrum.size() - 1);
        const float largest = *std::max_element(spectrum.begin() + std::ptrdiff_t(below), spectrum.end());
        const double weight = std::ldexp(double(largest) * double(largest), -4 * (int(level) + 1));
        detail.weight[level] = static_cast<float>(weight);
        detail.negligible[level] =
            static_cast<float>(std::min(std::sqrt(energy_of_a_cell / std::max(weight, 1e-37)), 1e30));
    }
    return detail;
}

void CoefficientEnergies::clear(std::size_t room) {
    if (place.size() < room) {
        energy.resize(room);
        place.resize(room);
        marks.resize(room);
    }
    blocks = 0;
    sum = 0;
}

/// Finds the largest fitting limit on a grid of float bit patterns, which are ordered like floats. The result
/// does not depend on where the search starts. A single energy above `allowed` must be kept.
std::size_t CoefficientEnergies::mark(double allowed) {
    constexpr int grid_bits = 20;
    const auto limit_of = [](std::uint32_t at) { return std::bit_cast<float>(at << grid_bits); };
    const auto fits = [&](std::uint32_t at) {
        return double(HWY_DYNAMIC_DISPATCH(energy_below)(*this, limit_of(at))) <= allowed;
    };
    // Invariant: `low` fits, `high` does not; 0 drops nothing.
    const std::uint32_t end =
        (std::bit_cast<std::uint32_t>(static_cast<float>(std::min(allowed, 1e38))) >> grid_bits) + 1;
    std::uint32_t low = 0, high = end, middle = end - std::min(last_distance_, end), step = 1;
    if (middle > 0 && fits(middle)) {
        for (low = middle; step < high - low && fits(low + step); step *= 2) low += step;
        high = std::min(high, low + step);
    } else if (middle > 0) {
        for (high = middle; step < high && !fits(high - step); step *= 2) high -= step;
        low = high - std::min(high, step);
    }
    while (high - low > 1) {
        middle = low + (high - low) / 2;
        (fits(middle) ? low : high) = middle;
    }
    last_distance_ = end - low;
    return HWY_DYNAMIC_DISPATCH(mark_above)(*this, limit_of(low));
}

}  // namespace haarfield
#endif
