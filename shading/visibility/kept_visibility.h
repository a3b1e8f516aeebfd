#pragma once
/// What the vertices of a scene see, kept: for new light and new views of objects that stay where they are.

#include <cassert>
#include <memory>

#include "shading/visibility/vertex_visibility.h"

namespace haarfield {

/// Holds for the instances as they were; the geometry must outlive it.
class KeptVisibility {
public:
    /// Looks round once from each vertex that is not buried.
    ///
    /// most_bytes  beside 8 bytes a vertex. Vertices for which there is no more room are left out and have to
    ///             look round anew; which ones depends on the threads, what they see does not.
    /// memory      some 0.4 KB a vertex, and where near objects are rasterized another 6 KB.
    ///             [faces of 64 texels]
    /// cost        that of looking: from 1 us a vertex by fields to 50 us at contacts, on all of oneTBB's
    ///             threads.
    /// errors      interrupted.
    static Result<KeptVisibility> make(const ShadedScene& scene, const ShadingGeometry& geometry,
                                       std::size_t most_bytes, const Progress& progress = {});

    /// Null: not kept; without trees: the vertex sees nothing. Of the scene's instances and vertices as they
    /// were (asserted).
    const VertexSight* find(std::size_t instance, std::uint32_t vertex) const {
        assert(instance < sights_.size() && vertex < sights_[instance].size());
        return sights_[instance][vertex];
    }

    std::size_t bytes() const { return bytes_; }  ///< With those 8 a vertex.

private:
    std::vector<std::vector<const VertexSight*>> sights_;  ///< By instance and vertex.
    std::vector<std::unique_ptr<std::byte[]>> memory_;     ///< Where these are, and what they refer to.
    std::size_t bytes_ = 0;
};

}  // namespace haarfield
