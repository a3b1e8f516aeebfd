#pragma once
/// Selection of the coefficients to keep for an allowed error.

#include <algorithm>
#include <span>

namespace haarfield {

/// Reorders items so that the kept ones come first, and returns their number: the smallest for which the
/// energies of all others sum to at most `allowed`.
///
/// energy_of     the energy of an item, >= 0.
/// matters_more  a strict order of all items by decreasing energy.
/// accuracy      energies are summed in double, in the order in which std::nth_element leaves them. If
///               rounding decides, the choice may differ between standard libraries.
/// cost          linear on average: each step tests the less important half of the undecided items as a
///               whole, and drops it if its total energy is allowed.
template <class Item, class EnergyOf, class MattersMore>
std::size_t largest_by_energy(std::span<Item> items, double allowed, const EnergyOf& energy_of,
                              const MattersMore& matters_more) {
    auto kept = items.begin(), end = items.end();
    while (kept != end) {
        const auto middle = kept + (end - kept) / 2;
        std::nth_element(kept, middle, end, matters_more);
        double smaller = 0;
        for (auto item = middle; item != end; ++item) smaller += energy_of(*item);
        if (smaller <= allowed) {
            allowed -= smaller;
            end = middle;
        } else {
            kept = middle == kept ? end : middle;
        }
    }
    return static_cast<std::size_t>(kept - items.begin());
}

}  // namespace haarfield
