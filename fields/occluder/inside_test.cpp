#include "fields/occluder/occluder.h"

namespace haarfield {

InsideTest::InsideTest(const Occluder& occluder) : occluder_(occluder) {}

bool InsideTest::operator()(const Vec3f& point) const {
    const Bounds& bounds = occluder_.bounds();
    for (int k = 0; k < 3; ++k)
        if (!(point[k] >= bounds.lower[k] && point[k] <= bounds.upper[k])) return false;
    int votes = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const int across = axis_frames[std::size_t(axis)].across, up = axis_frames[std::size_t(axis)].up;
        // A ray along the axis, slightly shifted, so that it misses edges and vertices of axis-aligned
        // geometry.
        const double shift = 1.1e-6 * bounds.radius();
        const double px = double(point[across]) + 1.37 * shift, py = double(point[up]) + 0.81 * shift,
                     pz = point[axis];
        int winding = 0;
        occluder_.grids()[std::size_t(axis)].visit_triangles_at(px, py, [&](std::uint32_t number) {
            if (number >= occluder_.one_sided()) return;
            const auto& t = occluder_.triangles()[number];
            double x[3], y[3], z[3];
            for (std::size_t k = 0; k < 3; ++k) {
                x[k] = occluder_.positions()[t[k]][across] - px;
                y[k] = occluder_.positions()[t[k]][up] - py;
                z[k] = occluder_.positions()[t[k]][axis] - pz;
            }
            const double w0 = x[1] * y[2] - x[2] * y[1], w1 = x[2] * y[0] - x[0] * y[2],
                         w2 = x[0] * y[1] - x[1] * y[0];
            const bool positive = w0 > 0 && w1 > 0 && w2 > 0, negative = w0 < 0 && w1 < 0 && w2 < 0;
            if (!positive && !negative) return;
            // The distance to the triangle's plane along the ray, times the absolute area.
            const double distance = (w0 * z[0] + w1 * z[1] + w2 * z[2]) * (positive ? 1 : -1);
            if (distance > 0) winding += positive ? 1 : -1;
        });
        votes += winding > 0;
    }
    return votes >= 2;
}

}  // namespace haarfield
