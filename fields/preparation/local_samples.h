#pragma once
/// Sample points for the visibility at the vertices of a fine mesh.

#include "fields/mesh/mesh.h"
#include "fields/mesh/surface_rays.h"
#include "fields/occluder/occluder.h"

#include <memory>
#include <optional>
#include <stop_token>

namespace haarfield {

/// Points just above the centroids of the triangles around a surface point, except triangles inside another
/// piece.
struct VisibleMiddles {
    Vec3f sum{0.0f};          ///< Sum of all points. [m]
    Vec3f nearest{0.0f};      ///< The one nearest to the surface point. [m]
    std::uint32_t count = 0;  ///< 0: the surface point is not visible.

    /// Adds the point of one more triangle, for a surface point at `position`.
    void add(const Vec3f& position, const Vec3f& middle);
};

/// Computes sample points for points of an entity's surface.
///
/// A surface point may also lie on other surfaces: at creases, at contacts, or where two pieces meet. These
/// surfaces would be viewed edge-on, so that they would not block anything. Therefore the sample is offset
/// along the normal by surface_offset. It is also moved by a twentieth of the way towards the centroids of
/// the adjacent triangles that are not inside another piece, upwards on concave surfaces but never downwards.
/// If it is then inside another piece, as at partly buried triangles, it moves towards the centroid of the
/// nearest triangle until it is outside. From inside a piece, visibility would be sampled through its back
/// faces. If a simplified two-sided occluder bulges over the point (its back is hit along the normal within a
/// fiftieth of the radius), the sample is lifted above the bulge.
///
/// Safe to share between threads.
class LocalSampler {
public:
    /// original, in_original  of the original mesh; the test must outlive the sampler.
    /// own                    the occluder of the entity for its own vertices; see EntityOcclusion.
    LocalSampler(const Occluder& original, const InsideTest& in_original, const Occluder& own);

    /// Returns the point just above a triangle's centroid; nothing if it is inside another piece of the
    /// entity.
    std::optional<Vec3f> visible_middle(const Vec3f& a, const Vec3f& b, const Vec3f& c) const;

    /// Returns the sample of a surface point with at least one such point around it. The sample is outside of
    /// all closed pieces, unless it was lifted.
    Vec3f sample(const Vec3f& position, const Vec3f& normal, const VisibleMiddles& middles) const;

private:
    Vec3f outside(const Vec3f& point, const Vec3f& visible) const;

    const InsideTest& in_original_;
    const float radius_;
    std::unique_ptr<const SurfaceRays> rays_;  // null if nothing bulges
};

/// The samples of the vertices of a fine mesh.
struct LocalSamples {
    std::vector<Vec3f> points;         ///< One per vertex of the fine mesh, next to the surface. [m]
    std::vector<std::uint8_t> buried;  ///< 1 if all triangles around the vertex are inside the entity.
};

/// Computes the samples of all vertices. stop: after a stop request, returns soon with unusable samples.
LocalSamples local_samples(const Mesh& fine, const LocalSampler& sampler, std::stop_token stop = {});

/// The offset of a sample above the surface, relative to the radius of the mesh.
inline constexpr float surface_offset = 1e-4f;

}  // namespace haarfield
