#pragma once
/// Meshes of single instances with the radiance of their vertices, in place of the fine meshes of entities.

#include <optional>

#include "shading/bake/renderer.h"

namespace haarfield {

/// The mesh of an instance with radiance, in the frame of its entity.
struct RadiantMesh {
    Mesh mesh;
    std::vector<Outgoing> radiance;                ///< By vertex. [W/(m^2 sr)]
    LocalSamples samples;                          ///< Sample points of the vertices.
    std::vector<GatheredIrradiance> irradiance{};  ///< Indirect, by vertex; empty: unknown.
};

/// Returns the difference between two radiances, summed over the channels. [W/(m^2 sr)]
inline float channel_difference(const Outgoing& a, const Outgoing& b) {
    const Rgb d = a.total() - b.total();
    return std::abs(d.x) + std::abs(d.y) + std::abs(d.z);
}

/// Returns the largest difference between two corners of a triangle, summed over the channels.
///
/// radiance  by vertex. [W/(m^2 sr)]
template <class Radiance>
float corner_difference(const Radiance& radiance, const std::array<std::uint32_t, 3>& corners) {
    float largest = 0;
    for (std::size_t k = 0; k < 3; ++k)
        largest = std::max(largest, channel_difference(radiance[corners[k]], radiance[corners[(k + 1) % 3]]));
    return largest;
}

/// Returns the radiance that a surface with this tint (ShadedEntity::tints) displays.
inline Outgoing tinted(const Outgoing& radiance, const Rgb& tint) {
    return {radiance.diffuse * tint, radiance.specular};
}

/// A mesh whose vertices can be shaded, in the frame of the instance's entity. Its pointers must outlive it.
struct SampledMesh {
    const Mesh* mesh = nullptr;
    const LocalSamples* samples = nullptr;  ///< Sample points of the vertices.
};

/// Returns a point of a mesh with its sample point.
///
/// triangles  the triangles that contain the point.
/// returns    nothing if all of these triangles are buried in other pieces of the entity.
std::optional<SurfacePoint> point_on(const Mesh& mesh, std::span<const std::uint32_t> triangles,
                                     const Vec3f& position, const Vec3f& normal, const LocalSampler& sampler);

/// Shades the vertices of meshes that replace the fine meshes of entities. Returns a mesh per instance.
///
/// meshes  by entity: other meshes of the same surface.
/// cost    see point_radiance.
/// errors  interrupted.
Result<std::vector<RadiantMesh>> mesh_radiance(const PointShading& shading, std::span<const Mesh> meshes,
                                               const Progress& progress = {});

/// Shades vertices of a mesh per instance: the fine mesh of its entity, or another mesh of the same surface.
///
/// wanted   the vertices to be shaded, by instance and vertex; empty: all. The radiance of others is 0.
/// returns  by instance and vertex. For fine meshes the result is that of scene_radiance.
/// cost     see point_radiance.
/// errors   interrupted.
Result<SceneRadiance> vertex_radiance(const PointShading& shading, std::span<const SampledMesh> meshes,
                                      const VertexMask& wanted, const Progress& progress = {});

/// A function that returns the values of points, in their order.
using PointRadiance = std::function<Result<std::vector<Outgoing>>(std::span<const InstancePoint>)>;

/// Evaluates a function at the vertices of meshes, with the arguments of vertex_radiance.
Result<SceneRadiance> vertex_values(const ShadedScene& scene, std::span<const SampledMesh> meshes,
                                    const VertexMask& wanted, const PointRadiance& radiance_of);

}  // namespace haarfield
