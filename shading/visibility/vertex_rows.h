#pragma once
/// A numbering of all vertices of a scene.

#include "shading/visibility/shading_geometry.h"

namespace haarfield {

/// A vertex of a scene.
struct InstanceVertex {
    std::size_t instance;
    std::uint32_t vertex;  ///< Of the fine mesh.
};

/// Numbers the vertices of a scene by rows: instance by instance, and within an instance along a
/// space-filling curve. Scene and geometry must outlive it.
class VertexRows {
public:
    VertexRows(const ShadedScene& scene, const ShadingGeometry& geometry);  ///< Numbers the vertices of a
                                                                            ///< scene.

    std::size_t count() const { return first_.back(); }                         ///< Rows of all instances.
    std::size_t first(std::size_t instance) const { return first_[instance]; }  ///< First row of an instance.
    /// Returns the vertices of an instance's rows.
    std::span<const std::uint32_t> vertices(std::size_t instance) const {
        return geometry_.entities[scene_.instances[instance].entity].order;
    }
    InstanceVertex operator[](std::size_t row) const;    ///< The vertex of a row.
    bool is_buried(const InstanceVertex& vertex) const;  ///< LocalSamples::buried.

private:
    const ShadedScene& scene_;
    const ShadingGeometry& geometry_;
    std::vector<std::size_t> first_;  ///< By instance, followed by the total.
};

/// Stores one value per row by instance and vertex. Buried vertices are filled in, and negative values become
/// zero.
///
/// wanted  null: all vertices. Otherwise these and the vertices that they are filled from are stored; the
///         values of other vertices are undefined, unless an earlier call stored them.
void store_radiance(const ShadedScene& scene, const ShadingGeometry& geometry, std::span<const Rgb> by_row,
                    SceneColours& radiance, const VertexMask* wanted = nullptr);

/// Returns the places of vertices among the rows of their instance, by entity and vertex.
std::vector<std::vector<std::uint32_t>> row_places(const ShadedScene& scene, const ShadingGeometry& geometry);

/// Returns the values of rows, from those of vertices.
std::vector<Rgb> row_values(const VertexRows& rows, const SceneColours& values);

}  // namespace haarfield
