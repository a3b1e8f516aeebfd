#pragma once
/// A visibility field as wide trees, the input of shading.

#include "fields/base/progress.h"
#include "fields/base/result.h"
#include "fields/field/visibility_field.h"
#include "shading/walk/wide_tree.h"

namespace haarfield {

/// Converts quadtrees of visibility on faces to wide trees, with one byte per cell.
///
/// Visibility lies in [0, 1], but truncated wavelets exceed this range; every cell is clamped to it. Clamping
/// removes the ripples in open and blocked regions, which become exactly 1 and 0, and never increases the
/// error.
///
/// accuracy  rounded to 1/255; squares on which visibility differs by less than 1/512 are constant.
class VisibilityConverter {
public:
    /// Appends the nodes of a face, root first; none if it is constant. Returns the mean of the face.
    float append(const Quadtree& tree, std::vector<WideNode<std::uint8_t>>& nodes);

private:
    /// A node, with its children: child_count entries of children_ from first_child.
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

    /// Builds the square of a node whose mean is given by the wavelets above it. Returns its mean after
    /// clamping all cells to [0, 1].
    Built build(const Quadtree& tree, std::int32_t index, float mean);
    void write(std::size_t index, std::size_t place, std::vector<WideNode<std::uint8_t>>& nodes) const;

    std::vector<Square> squares_;
    std::vector<std::int32_t> children_;  ///< Indices in squares_.
};

/// The trees of a field by sample, as VisibilityConverter makes them.
///
/// memory  24 bytes per node: about 1.6 times that of the field.
class WideVisibility {
public:
    /// Converts a field.
    ///
    /// order   order of the local samples in memory: that of their use.
    /// cost    about 20 ns per node of the field, in parallel on oneTBB.
    /// errors  interrupted.
    static Result<WideVisibility> make(const VisibilityField& field, std::span<const std::uint32_t> order,
                                       std::stop_token stop = {});

    /// Returns the tree of a planar sample.
    const WideCubemap<std::uint8_t>& planar(std::uint32_t sample) const { return planar_[sample]; }
    /// Returns the tree of a spherical sample.
    const WideCubemap<std::uint8_t>& spherical(std::uint32_t sample) const { return spherical_[sample]; }
    /// True if vertices have trees.
    bool has_local() const { return !local_.empty(); }
    /// Returns the tree of a vertex; only if has_local().
    const WideCubemap<std::uint8_t>& local(std::uint32_t vertex) const { return local_[vertex]; }
    std::size_t memory() const;  ///< [bytes]

private:
    std::vector<std::vector<WideNode<std::uint8_t>>> nodes_;
    std::vector<WideCubemap<std::uint8_t>> planar_, spherical_, local_;
};

}  // namespace haarfield
