#include "fields/mesh/sheet_backs.h"

#include "fields/base/spiral.h"
#include "fields/mesh/first_surface.h"
#include "fields/mesh/local_samples.h"
#include "fields/mesh/mesh_topology.h"
#include "fields/mesh/surface_rays.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

namespace haarfield {
namespace {

/// Spread evenly over the upper hemisphere about z.
std::array<Vec3f, 16> hemisphere_directions() {
    std::array<Vec3f, 16> directions;
    for (std::size_t i = 0; i < directions.size(); ++i)
        directions[i] = Vec3f(spiral_direction(i, (double(i) + 0.5) / double(directions.size())));
    return directions;
}

/// How far a ray from inside a box goes to the planes that bound it along an axis. [m]
float distance_to_side(const Bounds& box, const Vec3f& from, const Vec3f& direction, int axis) {
    if (direction[axis] == 0) return INFINITY;
    return ((direction[axis] > 0 ? box.upper : box.lower)[axis] - from[axis]) / direction[axis];
}

class BackView {
public:
    BackView(const Mesh& mesh, const Mesh& blocking)
        : mesh_(mesh),
          surface_(mesh.positions, mesh.triangles),
          blocking_(blocking),
          blocking_kinds_(triangle_kinds(blocking)),
          box_(mesh_bounds(mesh)),
          offset_(box_.radius() * surface_offset),
          directions_(hemisphere_directions()) {}

    bool is_seen(std::size_t triangle) const {
        const auto& [i, j, k] = mesh_.triangles[triangle];
        const Vec3f &a = mesh_.positions[i], &b = mesh_.positions[j], &c = mesh_.positions[k];
        const Vec3f normal = (b - a).cross(c - a).normalized(), middle = (a + b + c) / 3.0f;
        if (surface_.passes_a_back(middle + normal * offset_, -normal, 2 * offset_)) return false;
        if (looks_out(middle - normal * offset_, -normal)) return true;
        constexpr float large = 0.05f;  // [radii]
        const float longest = std::max({(b - a).length(), (c - b).length(), (a - c).length()});
        if (longest < large * box_.radius()) return false;
        for (const Vec3f& corner : {a, b, c})
            if (looks_out(middle + (corner - middle) * 0.7f - normal * offset_, -normal)) return true;
        return false;
    }

private:
    /// Tests whether a ray into the hemisphere about a unit vector leaves the box, but not through its
    /// bottom, or reaches the inside of a room.
    bool looks_out(const Vec3f& from, const Vec3f& up) const {
        const Vec3f aside = (std::abs(up.x) < 0.5f ? Vec3f(1, 0, 0) : Vec3f(0, 1, 0)).cross(up).normalized();
        const Vec3f across = up.cross(aside);
        return std::any_of(directions_.begin(), directions_.end(), [&](const Vec3f& d) {
            const Vec3f direction = aside * d.x + across * d.y + up * d.z;
            const float beside = std::min(distance_to_side(box_, from, direction, 0),
                                          distance_to_side(box_, from, direction, 2));
            if (direction.y < 0 && distance_to_side(box_, from, direction, 1) <= beside) return false;
            const std::optional<FirstSurface::Hit> hit = blocking_(from, direction);
            return !hit || (hit->is_front && blocking_kinds_[hit->triangle] == PieceKind::room);
        });
    }

    const Mesh& mesh_;
    const SurfaceRays surface_;
    const FirstSurface blocking_;
    const std::vector<PieceKind> blocking_kinds_;
    const Bounds box_;
    const float offset_;
    const std::array<Vec3f, 16> directions_;
};

}  // namespace

Mesh seen_backs(const Mesh& mesh, const Mesh& blocking) {
    Mesh backs;
    backs.material_names = mesh.material_names;
    std::vector<std::uint8_t> open = triangles_of_open_pieces(mesh);
    const std::vector<PieceKind> kinds = triangle_kinds(mesh);
    for (std::size_t t = 0; t < open.size(); ++t) open[t] |= kinds[t] == PieceKind::room ? 1 : 0;
    if (std::find(open.begin(), open.end(), 1) == open.end()) return backs;

    const BackView view(mesh, blocking);
    std::vector<std::uint8_t> is_seen(mesh.triangles.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, is_seen.size(), 256), [&](const auto& range) {
        for (std::size_t t = range.begin(); t != range.end(); ++t) is_seen[t] = open[t] && view.is_seen(t);
    });
    constexpr std::uint32_t none = UINT32_MAX;
    std::vector<std::uint32_t> back_of(mesh.positions.size(), none);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        if (!is_seen[t]) continue;
        auto back = mesh.triangles[t];
        std::swap(back[1], back[2]);
        for (std::uint32_t& corner : back) {
            std::uint32_t& vertex = back_of[corner];
            if (vertex == none) {
                vertex = static_cast<std::uint32_t>(backs.positions.size());
                backs.positions.push_back(mesh.positions[corner]);
                backs.normals.push_back(-mesh.normals[corner]);
                backs.vertex_materials.push_back(mesh.vertex_materials[corner]);
                if (!mesh.uvs.empty()) backs.uvs.push_back(mesh.uvs[corner]);
                if (!mesh.colours.empty()) backs.colours.push_back(mesh.colours[corner]);
            }
            corner = vertex;
        }
        backs.triangles.push_back(back);
    }
    return backs;
}

}  // namespace haarfield
