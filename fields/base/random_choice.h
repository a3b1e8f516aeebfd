#pragma once
/// A random choice that is the same on every platform: std::shuffle differs between standard libraries.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

namespace haarfield {

/// Keeps `wanted` of the items, chosen uniformly, in random order. If there are fewer, keeps and shuffles
/// all. The choice depends only on the number of items.
///
/// items   fewer than 2^32.
/// cost    one swap per kept item.
/// source  Fisher-Yates shuffle from the front, stopped after `wanted` steps. Step k draws r in [0, 2^32)
///         from std::mt19937 (seed 2006) and swaps the items k and k + floor(r (items - k) / 2^32).
template <class T>
void keep_random(std::vector<T>& items, std::size_t wanted) {
    std::mt19937 random(2006);
    wanted = std::min(wanted, items.size());
    for (std::size_t k = 0; k < wanted; ++k)
        std::swap(items[k], items[k + std::size_t((std::uint64_t(random()) * (items.size() - k)) >> 32)]);
    items.erase(items.begin() + std::ptrdiff_t(wanted), items.end());
}

}  // namespace haarfield
