#pragma once
/// Which coefficients are kept when an error is allowed.

#include <algorithm>
#include <span>

namespace haarfield {

/// Reorders items so that those that are kept come first, and returns how many: as few as can be, so that the
/// energies of all others add up to at most `allowed`.
///
/// energy_of     of an item: >= 0.
/// matters_more  a strict order of all items, by falling energy.
/// accuracy      energies are added up in double, in the order in which std::nth_element leaves them: which
///               items are kept may differ between standard libraries where rounding decides.
/// cost          linear, on the average: of the places of which it is not known whether they are kept the
///               half that matters less is looked at as a whole, and left out if all of it can be.
template <class Item, class EnergyOf, class MattersMore>
std::size_t kept_by_energy(std::span<Item> items, double allowed, const EnergyOf& energy_of,
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
