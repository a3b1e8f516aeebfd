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
            // The vertex's own triangles are met from the front on the way in, and passed through.
            moved[v] = rays.passes_a_back(fine.positions[v] + normal * offset, -normal, 2 * offset);
            if (moved[v]) fine.positions[v] += normal * offset;
        }
    });
    return static_cast<std::size_t>(std::count(moved.begin(), moved.end(), 1));
}

}  // namespace haarfield
