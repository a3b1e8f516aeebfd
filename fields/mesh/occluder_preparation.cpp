#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "fields/base/aligned_buffer.h"
#include "fields/mesh/occluder.h"

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
    // Relative to the middle, so that offsets keep their digits in a mesh far from the origin.
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
        // Of the rounded normal, through the middle.
        const Vec3d rounded = Vec3d(Vec3f(normal));
        if (!(rounded.length() > 0)) continue;
        planes.x[t] = static_cast<float>(rounded.x);
        planes.y[t] = static_cast<float>(rounded.y);
        planes.z[t] = static_cast<float>(rounded.z);
        planes.offset[t] = static_cast<float>(rounded.dot((a + b + c) / 3.0));
    }
    return planes;
}

AxisGrid axis_grid(const OccluderTriangles& source, const AxisFrame& frame) {
    const Vec3f extent = source.bounds.upper - source.bounds.lower;
    const int cells = std::clamp(static_cast<int>(std::sqrt(double(source.triangles.size()))), 1, 512);
    AxisGrid grid;
    grid.cells = cells;
    grid.lower = {source.bounds.lower[frame.across], source.bounds.lower[frame.up]};
    for (std::size_t k = 0; k < 2; ++k) {
        const float size = extent[k == 0 ? frame.across : frame.up];
        // Of an extent that is next to nothing there would be infinitely many.
        const float number = static_cast<float>(cells) / size;
        grid.cells_per_metre[k] = std::isfinite(number) ? number : 0.0f;
    }
    // Counting sort of the triangles into all cells that their boxes touch.
    const auto touched = [&](std::uint32_t t, auto&& visit) {
        int low[2] = {cells, cells}, high[2] = {0, 0};
        for (const std::uint32_t v : source.triangles[t])
            for (std::size_t k = 0; k < 2; ++k) {
                const int cell = grid.cell(source.positions[v][k == 0 ? frame.across : frame.up], k);
                low[k] = std::min(low[k], cell);
                high[k] = std::max(high[k], cell);
            }
        for (int y = low[1]; y <= high[1]; ++y)
            for (int x = low[0]; x <= high[0]; ++x) visit(static_cast<std::size_t>(y * cells + x));
    };
    const auto count = static_cast<std::uint32_t>(source.triangles.size());
    grid.first.assign(std::size_t(cells) * std::size_t(cells) + 1, 0);
    for (std::uint32_t t = 0; t < count; ++t) touched(t, [&](std::size_t cell) { ++grid.first[cell + 1]; });
    std::partial_sum(grid.first.begin(), grid.first.end(), grid.first.begin());
    grid.triangle.resize(grid.first.back());
    std::vector<std::uint32_t> next(grid.first.begin(), grid.first.end() - 1);
    for (std::uint32_t t = 0; t < count; ++t)
        touched(t, [&](std::size_t cell) { grid.triangle[next[cell]++] = t; });
    return grid;
}

}  // namespace

int AxisGrid::cell(float coordinate, std::size_t k) const {
    return static_cast<int>(
        std::clamp((coordinate - lower[k]) * cells_per_metre[k], 0.0f, static_cast<float>(cells - 1)));
}

std::span<const std::uint32_t> AxisGrid::triangles_at(float across, float up) const {
    const auto at = static_cast<std::size_t>(cell(up, 1) * cells + cell(across, 0));
    return {triangle.data() + first[at], first[at + 1] - first[at]};
}

Occluder::Occluder(OccluderTriangles source)
    : source_(std::move(source)),
      padded_positions_(padded(source_.positions)),
      planes_(occluder_planes(source_)),
      edges_(occluder_edges(source_, planes_)) {
    for (std::size_t axis = 0; axis < 3; ++axis) grids_[axis] = axis_grid(source_, axis_frames[axis]);
}

}  // namespace haarfield
