#include "fields/thin_sheets.h"

#include "fields/local_samples.h"
#include "fields/surface_rays.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

namespace haarfield {

std::size_t part_thin_sheets(Mesh& fine, const Mesh& original) {
    const SurfaceRays rays(original.positions, original.triangles);
    const float offset = mesh_bounds(original).radius() * surface_offset;
    std::vector<std::uint8_t> moved(fine.positions.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, fine.positions.size(), 256), [&](const auto& range) {
        for (std::size_t v = range.begin(); v != range.end(); ++v) {
            const Vec3f& normal = fine.normals[v];
            const Vec3f above = fine.positions[v] + normal * offset;
            // The vertex's own triangles are met from the front on the way in, and passed through. Where two
            // solids touch, above one is inside the other.
            moved[v] = rays.passes_a_back(above, -normal, 2 * offset) &&
                       rays.distance_to_back(above + normal * offset, normal, INFINITY) == 0;
            if (moved[v]) fine.positions[v] += normal * offset;
        }
    });
    return static_cast<std::size_t>(std::count(moved.begin(), moved.end(), 1));
}

}  // namespace haarfield
