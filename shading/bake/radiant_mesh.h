#pragma once
/// Meshes with the radiance of their vertices, an instance's own each, beside the fine meshes of entities.

#include <optional>

#include "shading/bake/renderer.h"

namespace haarfield {

/// In the frame of the instance's entity.
struct RadiantMesh {
    Mesh mesh;
    std::vector<Outgoing> radiance;  ///< By vertex. [W/(m^2 sr)]
    LocalSamples samples;            ///< Origins of the rays of its vertices.
};

/// A mesh whose vertices can be shaded, in the frame of the instance's entity; both outlive its use.
struct SampledMesh {
    const Mesh* mesh = nullptr;
    const LocalSamples* samples = nullptr;  ///< Of its vertices.
};

/// Where a point of a surface is shaded.
///
/// triangles  those of the mesh that the point lies on, or between.
/// returns    nothing if all of them are buried in other pieces of the entity.
std::optional<SurfacePoint> point_on(const Mesh& mesh, std::span<const std::uint32_t> triangles,
                                     const Vec3f& position, const Vec3f& normal, const LocalSampler& sampler);

/// Shades the vertices of meshes that are no entity's fine mesh, as scene_radiance does those that are; by
/// instance.
///
/// meshes  one per entity, of its surface.
/// cost    see point_radiance.
/// errors  interrupted.
Result<std::vector<RadiantMesh>> mesh_radiance(const PointShading& shading, std::span<const Mesh> meshes,
                                               const Progress& progress = {});

/// Shades vertices of meshes that are given by instance: the entity's fine mesh with its samples, or any
/// other of its surface.
///
/// wanted   by instance and vertex; empty: all. Of the others radiance is 0.
/// returns  by instance and vertex, as scene_radiance does where the meshes are the fine ones.
/// cost     see point_radiance.
/// errors   interrupted.
Result<SceneRadiance> vertex_radiance(const PointShading& shading, std::span<const SampledMesh> meshes,
                                      const VertexMask& wanted, const Progress& progress = {});

/// Returns values of points, in their order.
using PointRadiance = std::function<Result<std::vector<Outgoing>>(std::span<const InstancePoint>)>;

/// Evaluates a function at the vertices of meshes; otherwise as vertex_radiance.
Result<SceneRadiance> vertex_values(const ShadedScene& scene, std::span<const SampledMesh> meshes,
                                    const VertexMask& wanted, const PointRadiance& radiance_of);

}  // namespace haarfield
