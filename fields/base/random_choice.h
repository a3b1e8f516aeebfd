#pragma once
/// A few of many, at random, and the same ones everywhere: std::shuffle differs from library to library.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

namespace haarfield {

/// Leaves so many of the items, each as likely as any other, in random order; all of them, reordered, if
/// there are no more. The same choice from as many items on every machine.
///
/// items   fewer than 2^32.
/// cost    one swap an item that is left.
/// source  the shuffle of Fisher and Yates from the front, stopped once enough are chosen. The k-th step
///         takes a number r in [0, 2^32) from std::mt19937, seeded with 2006, and with it the item
///         k + floor(r (items - k) / 2^32).
template <class T>
void keep_random(std::vector<T>& items, std::size_t wanted) {
    std::mt19937 random(2006);
    wanted = std::min(wanted, items.size());
    for (std::size_t k = 0; k < wanted; ++k)
        std::swap(items[k], items[k + std::size_t((std::uint64_t(random()) * (items.size() - k)) >> 32)]);
    items.erase(items.begin() + std::ptrdiff_t(wanted), items.end());
}

}  // namespace haarfield
