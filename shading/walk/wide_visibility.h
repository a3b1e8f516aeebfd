#pragma once
/// A visibility field as wide trees: what shading walks.

#include "fields/base/progress.h"
#include "fields/base/result.h"
#include "fields/field/visibility_field.h"
#include "shading/walk/wide_tree.h"

namespace haarfield {

/// Makes wide trees of visibility on faces, one after the other, in one byte a cell.
///
/// Visibility lies in [0, 1], which its truncated wavelets leave; every cell is brought back into it. That
/// takes the ripples out of open and blocked regions, so that these are exactly 1 and 0, and never adds
/// error.
///
/// accuracy  rounded to 1/255; squares on which the visibility differs by less than 1/512 are constant.
class VisibilityConverter {
public:
    /// Appends the face's nodes, root first; none if it is constant. Returns its mean.
    float append(const Quadtree& tree, std::vector<WideNode<std::uint8_t>>& nodes);

private:
    /// A node, and its children: so many of children_, from the first on.
    struct Square {
        std::array<std::uint8_t, wide_cells> mean;
        std::uint16_t varying;
        std::uint16_t child_count;
        std::uint32_t first_child;
    };
    struct Built {
        float mean;
        std::int32_t square;  ///< no_node: constant.
    };

    /// The square of a node whose mean was given to it by the wavelets above: its mean once all its cells are
    /// in [0, 1].
    Built build(const Quadtree& tree, std::int32_t index, float mean);
    void write(std::size_t index, std::size_t place, std::vector<WideNode<std::uint8_t>>& nodes) const;

    std::vector<Square> squares_;
    std::vector<std::int32_t> children_;  ///< In squares_.
};

/// The trees of a field by sample, as VisibilityConverter makes them.
///
/// memory  24 bytes a node: about 1.6 times the field's own.
class WideVisibility {
public:
    /// order   of the local samples, in which they will be asked for and their trees lie in memory.
    /// cost    some 20 ns a node of the field, on all of oneTBB's threads.
    /// errors  interrupted.
    static Result<WideVisibility> make(const VisibilityField& field, std::span<const std::uint32_t> order,
                                       std::stop_token stop = {});

    /// Of a planar sample.
    const WideCubemap<std::uint8_t>& planar(std::uint32_t sample) const { return planar_[sample]; }
    /// Of a spherical sample.
    const WideCubemap<std::uint8_t>& spherical(std::uint32_t sample) const { return spherical_[sample]; }
    /// Of a vertex.
    const WideCubemap<std::uint8_t>& local(std::uint32_t vertex) const { return local_[vertex]; }
    std::size_t memory() const;  ///< [bytes]

private:
    std::vector<std::vector<WideNode<std::uint8_t>>> nodes_;
    std::vector<WideCubemap<std::uint8_t>> planar_, spherical_, local_;
};

}  // namespace haarfield
