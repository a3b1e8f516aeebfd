#include "fields/preparation/thin_sheets.h"

#include "fields/mesh/surface_rays.h"
#include "fields/occluder/occluder.h"
#include "fields/preparation/local_samples.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <optional>

namespace haarfield {

std::size_t part_thin_sheets(Mesh& fine, const Mesh& original) {
    const SurfaceRays rays(original.positions, original.triangles);
    const float offset = mesh_bounds(original).radius() * surface_offset;
    struct Facet {
        Vec3f normal, above;  // above: just above its centroid
    };
    const auto facet = [&](std::size_t t) {
        const Vec3f &a = fine.positions[fine.triangles[t][0]], &b = fine.positions[fine.triangles[t][1]],
                    &c = fine.positions[fine.triangles[t][2]];
        const Vec3f normal = (b - a).cross(c - a).normalized();
        return Facet{normal, (a + b + c) / 3.0f + normal * offset};
    };
    std::vector<std::uint8_t> lies_on_a_back(fine.triangles.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, fine.triangles.size(), 256), [&](const auto& range) {
        // The ray hits the triangle itself from the front, which is ignored.
        for (std::size_t t = range.begin(); t != range.end(); ++t) {
            const Facet seen = facet(t);
            lies_on_a_back[t] = rays.passes_a_back(seen.above, -seen.normal, 2 * offset);
        }
    });
    std::vector<std::uint8_t> moves(fine.positions.size()), stays(fine.positions.size());
    const auto mark = [&](std::size_t t, std::vector<std::uint8_t>& vertices) {
        for (const std::uint32_t v : fine.triangles[t]) vertices[v] = 1;
    };
    std::optional<Occluder> occluder;  // built on first use
    std::optional<InsideTest> is_inside;
    for (std::size_t t = 0; t < fine.triangles.size(); ++t) {
        if (!lies_on_a_back[t]) {
            mark(t, stays);
            continue;
        }
        if (!occluder) is_inside.emplace(occluder.emplace(make_occluder(original)));
        const bool touches_a_solid = (*is_inside)(facet(t).above);
        mark(t, touches_a_solid ? stays : moves);
    }
    std::size_t count = 0;
    for (std::size_t v = 0; v < moves.size(); ++v)
        if (moves[v] && !stays[v]) {
            fine.positions[v] += fine.normals[v] * offset;
            ++count;
        }
    return count;
}

}  // namespace haarfield
