#pragma once
/// Shared edges of triangles, and connected pieces.

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <vector>

namespace haarfield {

/// A directed edge of a triangle.
struct EdgeUse {
    std::uint32_t low, high;
    std::uint32_t triangle;
    bool forward;  ///< From low to high.
};

/// True if two uses are of the same edge.
inline bool same_edge(const EdgeUse& a, const EdgeUse& b) {
    return a.low == b.low && a.high == b.high;
}

/// Returns all uses, sorted so that the uses of an undirected edge are adjacent, in the order of their
/// triangles.
inline std::vector<EdgeUse> sorted_edge_uses(const std::vector<std::array<std::uint32_t, 3>>& triangles) {
    std::vector<EdgeUse> uses;
    uses.reserve(3 * triangles.size());
    for (std::uint32_t t = 0; t < triangles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t from = triangles[t][k], to = triangles[t][(k + 1) % 3];
            uses.push_back({std::min(from, to), std::max(from, to), t, from < to});
        }
    std::sort(uses.begin(), uses.end(), [](const EdgeUse& a, const EdgeUse& b) {
        return a.low != b.low ? a.low < b.low : a.high != b.high ? a.high < b.high : a.triangle < b.triangle;
    });
    return uses;
}

/// Union-find over triangles.
struct Pieces {
    std::vector<std::uint32_t> parent;

    /// Creates one piece per element.
    explicit Pieces(std::size_t count) : parent(count) { std::iota(parent.begin(), parent.end(), 0u); }
    /// Returns the representative of the piece of i.
    std::uint32_t root(std::uint32_t i) {
        while (parent[i] != i) i = parent[i] = parent[parent[i]];
        return i;
    }
    /// Merges the pieces of i and j.
    void join(std::uint32_t i, std::uint32_t j) { parent[root(i)] = root(j); }
};

}  // namespace haarfield
