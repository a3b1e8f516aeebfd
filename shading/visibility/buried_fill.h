#pragma once
/// Radiance for vertices that see nothing: that of their neighbours.

#include <span>

#include "fields/mesh/mesh.h"

namespace haarfield {

/// Gives each buried vertex the mean radiance of its unburied neighbours along the edges, then of those in
/// turn, until no more can be reached. Made once per mesh.
class BuriedFill {
public:
    BuriedFill() = default;

    /// buried  by vertex: 1 where it is.
    /// cost    O(triangles) and O(edges at buried vertices) for each step inwards.
    BuriedFill(const Mesh& mesh, std::span<const std::uint8_t> buried);

    /// Fills in values by vertex: Rgb or Outgoing. Values that cannot be reached do not change.
    ///
    /// cost    one addition per edge of a triangle that ends in a buried vertex.
    template <class Value>
    void operator()(std::vector<Value>& values) const {
        std::size_t i = 0;
        for (const auto& [vertex, end] : filled_) {
            const auto count = static_cast<float>(end - i);
            Value sum = values[source_[i++]];
            while (i < end) sum += values[source_[i++]];
            values[vertex] = sum / count;
        }
    }

    /// Adds to a choice of vertices those that its buried ones take their radiance from.
    void add_sources(std::span<std::uint8_t> is_chosen) const;

private:
    struct Filled {
        std::uint32_t vertex;
        std::uint32_t end;  ///< Of its sources.
    };
    std::vector<Filled> filled_;  ///< Those that come later may be filled from those that came before.
    std::vector<std::uint32_t> source_;
};

/// Marks the buried vertices and more, so that of each triangle's one at least is not marked, if it was not
/// before: where the others can take from what changes slowly.
///
/// buried   by vertex: 1 where it is.
/// returns  likewise; some two of three are marked.
std::vector<std::uint8_t> left_out_vertices(const Mesh& mesh, std::span<const std::uint8_t> buried);

}  // namespace haarfield
