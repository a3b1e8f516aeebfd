#pragma once
/// Extrapolates radiance to buried vertices, which receive no light.

#include <span>

#include "fields/mesh/mesh.h"

namespace haarfield {

/// Assigns each buried vertex the mean radiance of its unburied neighbours along edges. Continues inwards
/// with the vertices filled so far, until no more can be reached. Built once per mesh.
class BuriedFill {
public:
    BuriedFill() = default;

    /// buried  by vertex: 1 if buried.
    /// cost    O(triangles), and O(edges at buried vertices) for each step inwards.
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

    /// Adds to a selection the vertices from which its buried vertices are filled.
    void add_sources(std::span<std::uint8_t> is_chosen) const;

private:
    struct Filled {
        std::uint32_t vertex;
        std::uint32_t end;  ///< End of its range in source_.
    };
    std::vector<Filled> filled_;  ///< Later entries may be filled from earlier ones.
    std::vector<std::uint32_t> source_;
};

/// Marks buried and other vertices to be skipped and filled from their neighbours, which suits slowly varying
/// quantities. At least one vertex of each triangle stays unmarked, unless it is buried.
///
/// buried   by vertex: 1 if buried.
/// returns  by vertex: 1 if marked; about two of three are.
std::vector<std::uint8_t> left_out_vertices(const Mesh& mesh, std::span<const std::uint8_t> buried);

}  // namespace haarfield
