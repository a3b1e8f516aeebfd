#pragma once
/// A cache of the visibility of all vertices, for new light and new views while objects stay in place.

#include <cassert>
#include <memory>

#include "shading/visibility/vertex_visibility.h"

namespace haarfield {

/// Valid for the instances as placed at construction. The geometry must outlive it.
class CachedVisibility {
public:
    /// Computes the visibility of each vertex that is not buried.
    ///
    /// most_bytes  memory in addition to 8 bytes per vertex. Vertices that exceed it are not cached and must
    ///             be evaluated again. Which vertices these are depends on the threads; their visibility does
    ///             not.
    /// memory      about 0.4 KB per vertex, and 6 KB more where nearby objects are rasterized. [faces of 64
    ///             texels]
    /// cost        from 1 us per vertex with fields to 50 us at contacts, in parallel on oneTBB.
    /// errors      interrupted.
    static Result<CachedVisibility> make(const ShadedScene& scene, const ShadingGeometry& geometry,
                                         std::size_t most_bytes, const Progress& progress = {});

    /// Returns the visibility of a vertex of the cached scene (asserted): null if it is not cached, without
    /// trees if the vertex is inside another instance.
    const VisibilityProduct* find(std::size_t instance, std::uint32_t vertex) const {
        assert(instance < products_.size() && vertex < products_[instance].size());
        return products_[instance][vertex];
    }

    std::size_t bytes() const { return bytes_; }  ///< Including the 8 bytes per vertex.

private:
    std::vector<std::vector<const VisibilityProduct*>> products_;  ///< By instance and vertex.
    std::vector<std::unique_ptr<std::byte[]>> memory_;  ///< Storage of the visibilities and their trees.
    std::size_t bytes_ = 0;
};

}  // namespace haarfield
