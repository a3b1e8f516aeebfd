#pragma once
/// Going through the vertices of a scene: what is the same whichever way their radiance is computed.

#include "fields/base/progress.h"
#include "fields/base/result.h"
#include "shading/scene/outgoing.h"
#include "shading/scene/shaded_scene.h"

namespace haarfield {

/// A point of an entity's surface, in the entity's own frame.
struct SurfacePoint {
    Vec3f position;              ///< [m]
    Vec3f normal;                ///< Unit length.
    Vec3f sample;                ///< Off the surface, beside it: where it looks from; see local_samples. [m]
    std::uint16_t material = 0;  ///< Index in ShadedEntity::materials.
};

/// A vertex of the entity's fine mesh.
SurfacePoint surface_point(const ShadedEntity& entity, std::uint32_t vertex);

/// What every evaluation of a vertex starts from.
struct VertexView {
    Vec3f normal;
    Vec3f mirror;    ///< The view direction, mirrored about the normal.
    Vec3f position;  ///< Of the vertex itself, in the world.
    Vec3f point;     ///< In the world; where the visibility past other instances is looked up.
};

/// The direction from a point towards the eye, mirrored about the normal. From behind the surface it is seen
/// as from its plane.
Vec3f mirrored_view(const Vec3f& eye, const Vec3f& position, const Vec3f& normal);

/// The view of one point of an instance from the scene's eye.
///
/// VertexView::point is the local sample, drawn towards the middle of its instance by a thousandth of the
/// radius, but by no more than 1 mm: what stands exactly on the floor shall not lie in the floor's plane.
VertexView vertex_view(const ShadedScene& scene, const ShadedInstance& instance, const SurfacePoint& point);

/// The same of a vertex.
VertexView vertex_view(const ShadedScene& scene, const ShadedInstance& instance, std::uint32_t vertex);

/// The points' numbers along a space-filling curve, so that neighbours in the order are neighbours in space.
std::vector<std::uint32_t> spatial_order(std::span<const Vec3f> points);

/// Does something at a vertex of an instance.
using VertexVisitor = std::function<void(std::size_t instance, std::uint32_t vertex)>;

/// Visits every vertex that is not buried (LocalSamples::buried), by all of oneTBB's threads.
///
/// orders        of each entity's vertices, in which they are visited.
/// make_visitor  makes a visitor for one thread, with that thread's buffers; what it does may depend on
///               nothing but its arguments, so that the threads' number changes nothing.
/// stage         what progress is told.
/// errors        interrupted.
Result<Done> visit_vertices(const ShadedScene& scene, std::span<const std::span<const std::uint32_t>> orders,
                            const std::function<VertexVisitor()>& make_visitor, std::string_view stage,
                            const Progress& progress);

/// Some of a scene's vertices: 1, by instance and vertex of its fine mesh; 0 for the others.
using VertexMask = std::vector<std::vector<std::uint8_t>>;

/// Does something at neighbouring vertices of an instance: at most 64.
using VertexRunVisitor = std::function<void(std::size_t instance, std::span<const std::uint32_t> vertices)>;

/// visit_vertices, many at a time. Which of them come together does not depend on the threads.
Result<Done> visit_vertex_runs(const ShadedScene& scene,
                               std::span<const std::span<const std::uint32_t>> orders,
                               const std::function<VertexRunVisitor()>& make_visitor, std::string_view stage,
                               const Progress& progress);

/// Returns a black value for each vertex.
SceneRadiance black_vertices(const ShadedScene& scene);

}  // namespace haarfield
