#include "fields/rasterizer/viewed_occluder.h"

#include <algorithm>

namespace haarfield {

// A triangle of altitude a, viewed at distance r from a height h above its plane, has an angular width of a h
// / r^2. The error of a side's image is a small multiple of the float rounding error, divided by the sine of
// the angle between side and ray. The same sine foreshortens the triangle's other extent, so that it cancels
// in the product of error and extent. What remains is a comparison of a h with a multiple of r^2.
ViewedOccluder look_at(const Occluder& occluder, const Vec3f& view_point, const Vec3f* horizon,
                       const Rotation* turn) {
    const double thinnest = turn ? 1e-6 : 5e-7;  // Rotating adds rounding errors. [rad]
    const Vec3d from_centre = Vec3d(view_point) - occluder.planes().centre;
    const double farthest = from_centre.length() + occluder.bounds().radius();
    ViewedOccluder viewed;
    viewed.view_point = view_point;
    viewed.from_centre = Vec3f(from_centre);
    viewed.thin = static_cast<float>(thinnest * farthest * farthest);
    if (horizon) {
        viewed.horizon = true;
        viewed.up = *horizon;
        viewed.object_up = turn ? turn->back(*horizon) : *horizon;
        viewed.lowest = 1e-5f * occluder.bounds().radius();
    }
    if (turn) {
        viewed.is_turned = true;
        for (std::size_t axis = 0; axis < 3; ++axis) viewed.axes[axis] = Vec3f(turn->row[axis]);
    }
    return viewed;
}

int facing(const Occluder& occluder, const ViewedOccluder& viewed, std::uint32_t triangle) {
    const OccluderPlanes& planes = occluder.planes();
    const Vec3f& p = viewed.from_centre;
    const float height = planes.x[triangle] * p.x + planes.y[triangle] * p.y + planes.z[triangle] * p.z -
                         planes.offset[triangle];
    const bool front = height > viewed.thin, back = height < -viewed.thin && triangle >= occluder.one_sided();
    if (!front && !back) return 0;
    if (occluder.edges().loose[triangle / 64] >> (triangle % 64) & 1) return 0;
    const auto is_below = [&](std::uint32_t v) {
        const Vec3f at = viewed.viewed(occluder.positions()[v]);
        return viewed.up.x * at.x + viewed.up.y * at.y + viewed.up.z * at.z <= viewed.lowest;
    };
    const auto& vertices = occluder.triangles()[triangle];
    if (viewed.horizon && std::all_of(vertices.begin(), vertices.end(), is_below)) return 0;
    return front ? 1 : -1;
}

}  // namespace haarfield
