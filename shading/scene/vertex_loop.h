#pragma once
/// Loops over the vertices of a scene, independent of how radiance is computed.

#include "fields/base/progress.h"
#include "fields/base/result.h"
#include "shading/scene/shaded_scene.h"
#include "shading/walk/outgoing.h"

namespace haarfield {

/// A point on an entity's surface, in the entity's frame.
struct SurfacePoint {
    Vec3f position;              ///< [m]
    Vec3f normal;                ///< Unit length.
    Vec3f sample;                ///< Point next to the surface from which visibility is sampled; see
                                 ///< local_samples. [m]
    std::uint16_t material = 0;  ///< Index in ShadedEntity::materials.
};

/// Returns a vertex of the entity's fine mesh as a surface point.
SurfacePoint surface_point(const ShadedEntity& entity, std::uint32_t vertex);

/// A point to be shaded, in the world.
struct ShadingPoint {
    Vec3f position{0.0f};  ///< On the surface. [m]
    Vec3f from{0.0f};      ///< Origin of its rays, off the surface. [m]
    Vec3f outside{0.0f};   ///< Where visibility around other instances is evaluated. [m]
    VertexBrdf brdf;       ///< With the normal, and the view direction mirrored about it.
};

/// Returns the direction from a point to the eye, mirrored about the normal. An eye behind the surface is
/// first projected to the tangent plane.
Vec3f mirrored_view(const Vec3f& eye, const Vec3f& position, const Vec3f& normal);

/// Returns a point of an instance as the scene's eye sees it.
///
/// ShadingPoint::outside is the local sample, moved towards the centre of its instance by a thousandth of the
/// radius, but by no more than 1 mm: a point of an object that stands on the floor must not lie in the
/// floor's plane.
ShadingPoint shading_point(const ShadedScene& scene, const ShadedInstance& instance,
                           const SurfacePoint& point);

/// Returns a vertex of an instance.
ShadingPoint shading_point(const ShadedScene& scene, const ShadedInstance& instance, std::uint32_t vertex);

/// Returns the points' indices along a space-filling curve, so that neighbours in the order are neighbours in
/// space.
std::vector<std::uint32_t> spatial_order(std::span<const Vec3f> points);

/// Called for a vertex of an instance.
using VertexVisitor = std::function<void(std::size_t instance, std::uint32_t vertex)>;

/// Visits every vertex that is not buried (LocalSamples::buried), in parallel on oneTBB.
///
/// orders        by entity: the order in which its vertices are visited.
/// make_visitor  makes a visitor with buffers for one thread. The effect of a visitor depends on its
///               arguments alone, so that results do not depend on the number of threads.
/// stage         name of the loop in progress reports.
/// errors        interrupted.
Result<Done> visit_vertices(const ShadedScene& scene, std::span<const std::span<const std::uint32_t>> orders,
                            const std::function<VertexVisitor()>& make_visitor, std::string_view stage,
                            const Progress& progress);

/// Some of a scene's vertices: 1, by instance and vertex of its fine mesh; 0 for the others.
using VertexMask = std::vector<std::vector<std::uint8_t>>;

/// Called for at most 64 neighbouring vertices of an instance.
using VertexRunVisitor = std::function<void(std::size_t instance, std::span<const std::uint32_t> vertices)>;

/// Visits vertices as visit_vertices, in runs. The runs do not depend on the threads.
Result<Done> visit_vertex_runs(const ShadedScene& scene,
                               std::span<const std::span<const std::uint32_t>> orders,
                               const std::function<VertexRunVisitor()>& make_visitor, std::string_view stage,
                               const Progress& progress);

/// Returns a black value for each vertex.
SceneRadiance black_vertices(const ShadedScene& scene);

}  // namespace haarfield
