#pragma once
/// Where the visibility of the vertices of a fine mesh is sampled.

#include "fields/mesh/mesh.h"
#include "fields/mesh/surface_rays.h"
#include "fields/occluder/occluder.h"

#include <memory>
#include <optional>
#include <stop_token>

namespace haarfield {

/// Of those triangles round a point of a surface that are not buried in another piece: places right over
/// their middles.
struct VisibleMiddles {
    Vec3f sum{0.0f};          ///< Of all. [m]
    Vec3f nearest{0.0f};      ///< To the point. [m]
    std::uint32_t count = 0;  ///< 0: the point can not be seen.

    /// The middle of one more triangle, for a point at the position.
    void add(const Vec3f& position, const Vec3f& middle);
};

/// Finds where points of an entity's surface look from.
///
/// A point lies on the surface, and on a crease, at a contact or where two pieces meet on other surfaces
/// too, which would be seen edge-on, that is, not at all. So its sample is offset along the normal by
/// surface_offset, and moved by a twentieth of the way towards the middle of the point's own triangles that
/// are not buried in another piece; up with them where they are hollow, but not down. If that lies in another
/// piece, as with triangles that are buried in part, it moves on towards the middle of the nearest of them
/// until it is outside: what can be seen of the surface begins there, and from inside a piece one would look
/// out through its back. Where a simplified two-sided occluder bulges over the point (its back is met along
/// the normal within a fiftieth of the radius), the sample is lifted above the bulge.
///
/// Safe to share between threads.
class LocalSampler {
public:
    /// original, in_original  of the mesh as it was read; the test must outlive the sampler.
    /// own                    what the points see of the entity; see EntityOcclusion.
    LocalSampler(const Occluder& original, const InsideTest& in_original, const Occluder& own);

    /// The place right over a triangle's middle; nothing if it lies inside another piece of the entity, that
    /// is, if the triangle is buried.
    std::optional<Vec3f> visible_middle(const Vec3f& a, const Vec3f& b, const Vec3f& c) const;

    /// The sample of a point with these middles round it, of which there is one at least: outside of all
    /// closed pieces, but where it is lifted.
    Vec3f sample(const Vec3f& position, const Vec3f& normal, const VisibleMiddles& middles) const;

private:
    Vec3f outside(const Vec3f& point, const Vec3f& visible) const;

    const InsideTest& in_original_;
    const float radius_;
    std::unique_ptr<const SurfaceRays> rays_;  // null if nothing bulges
};

/// Where the vertices of a fine mesh look from.
struct LocalSamples {
    std::vector<Vec3f> points;         ///< One per vertex of the fine mesh: off the surface, beside it. [m]
    std::vector<std::uint8_t> buried;  ///< 1 where all triangles round the vertex lie inside the entity.
};

/// stop  when it is requested, returns soon, and the samples are of no use.
LocalSamples local_samples(const Mesh& fine, const LocalSampler& sampler, std::stop_token stop = {});

/// The offset of a sample above the surface. [radii]
inline constexpr float surface_offset = 1e-4f;

}  // namespace haarfield
