#include <algorithm>
#include <limits>

#include "fields/base/aligned_buffer.h"
#include "fields/occluder/occluder.h"

namespace haarfield {
namespace {

std::vector<float> padded(const std::vector<Vec3f>& positions) {
    std::vector<float> result(4 * (positions.size() + widest_vector<float>), 0.0f);
    for (std::size_t v = 0; v < positions.size(); ++v)
        for (int k = 0; k < 3; ++k) result[4 * v + std::size_t(k)] = positions[v][k];
    return result;
}

OccluderPlanes occluder_planes(const OccluderTriangles& source) {
    OccluderPlanes planes;
    // Relative to the centre, for precision in meshes far from the origin.
    planes.centre = source.positions.empty() ? Vec3d(0.0) : Vec3d(source.bounds.centre());
    const std::size_t padded = (source.triangles.size() + 63) / 64 * 64;
    for (std::vector<float>* coordinate : {&planes.x, &planes.y, &planes.z}) coordinate->assign(padded, 0.0f);
    planes.offset.assign(padded, std::numeric_limits<float>::quiet_NaN());
    for (std::size_t t = 0; t < source.triangles.size(); ++t) {
        const auto& [i, j, k] = source.triangles[t];
        const Vec3d a = Vec3d(source.positions[i]) - planes.centre,
                    b = Vec3d(source.positions[j]) - planes.centre,
                    c = Vec3d(source.positions[k]) - planes.centre;
        const double longest = std::max({(b - a).length(), (c - b).length(), (a - c).length()});
        const Vec3d normal = (b - a).cross(c - a) / longest;
        // The plane of the rounded normal, through the centroid.
        const Vec3d rounded = Vec3d(Vec3f(normal));
        if (!(rounded.length() > 0)) continue;
        planes.x[t] = static_cast<float>(rounded.x);
        planes.y[t] = static_cast<float>(rounded.y);
        planes.z[t] = static_cast<float>(rounded.z);
        planes.offset[t] = static_cast<float>(rounded.dot((a + b + c) / 3.0));
    }
    return planes;
}

}  // namespace

Occluder::Occluder(OccluderTriangles source, OccluderUse use) : source_(std::move(source)) {
    if (use == OccluderUse::rasterized) {
        padded_positions_ = padded(source_.positions);
        planes_ = occluder_planes(source_);
        edges_ = occluder_edges(source_, planes_);
    }
    for (std::size_t axis = 0; axis < 3; ++axis)
        grids_[axis] = axis_grid(source_.positions, source_.triangles, axis_frames[axis]);
}

}  // namespace haarfield
