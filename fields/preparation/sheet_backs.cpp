#include "fields/preparation/sheet_backs.h"

#include "fields/base/spiral.h"
#include "fields/mesh/first_surface.h"
#include "fields/mesh/mesh_topology.h"
#include "fields/mesh/surface_rays.h"
#include "fields/preparation/local_samples.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

namespace haarfield {
namespace {

constexpr std::uint32_t none = UINT32_MAX;

/// Returns directions that are evenly distributed over the upper hemisphere about z.
std::vector<Vec3f> hemisphere_directions(std::size_t count) {
    std::vector<Vec3f> directions(count);
    for (std::size_t i = 0; i < directions.size(); ++i)
        directions[i] = Vec3f(spiral_direction(i, (double(i) + 0.5) / double(directions.size())));
    return directions;
}

/// Returns the distance from a point in a box to the bounding plane along an axis that a ray hits. [m]
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
          reduced_directions_(hemisphere_directions(16)),
          many_directions_(hemisphere_directions(128)) {}

    /// Tests whether a triangle is modelled with a back.
    bool has_back(std::size_t triangle) const {
        const Place at = place(triangle);
        return surface_.passes_a_back(at.middle + at.normal * offset_, -at.normal, 2 * offset_);
    }

    bool is_seen(std::size_t triangle) const {
        const Place at = place(triangle);
        if (looks_out(at.middle - at.normal * offset_, -at.normal, reduced_directions_)) return true;
        constexpr float large = 0.05f;  // [radii]
        const auto& [a, b, c] = at.corners;
        const float longest = std::max({(b - a).length(), (c - b).length(), (a - c).length()});
        if (longest < large * box_.radius()) return false;
        return std::any_of(at.corners.begin(), at.corners.end(), [&](const Vec3f& corner) {
            const Vec3f from = at.middle + (corner - at.middle) * 0.7f - at.normal * offset_;
            return looks_out(from, -at.normal, reduced_directions_);
        });
    }

    /// Like is_seen, with more rays, from the centroid.
    bool is_seen_closely(std::size_t triangle) const {
        const Place at = place(triangle);
        return looks_out(at.middle - at.normal * offset_, -at.normal, many_directions_);
    }

private:
    struct Place {
        std::array<Vec3f, 3> corners;
        Vec3f middle, normal;
    };

    Place place(std::size_t triangle) const {
        const auto& [i, j, k] = mesh_.triangles[triangle];
        const Vec3f &a = mesh_.positions[i], &b = mesh_.positions[j], &c = mesh_.positions[k];
        return {{a, b, c}, (a + b + c) / 3.0f, (b - a).cross(c - a).normalized()};
    }

    /// Tests whether any ray into the hemisphere about a unit vector leaves the box other than through its
    /// bottom, or reaches the inside of a room.
    bool looks_out(const Vec3f& from, const Vec3f& up, const std::vector<Vec3f>& directions) const {
        const Vec3f aside = (std::abs(up.x) < 0.5f ? Vec3f(1, 0, 0) : Vec3f(0, 1, 0)).cross(up).normalized();
        const Vec3f across = up.cross(aside);
        return std::any_of(directions.begin(), directions.end(), [&](const Vec3f& d) {
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
    const std::vector<Vec3f> reduced_directions_, many_directions_;
};

/// By triangle: whether it may have a back, and whether that back is visible.
struct Backs {
    std::vector<std::uint8_t> possible;
    std::vector<std::uint8_t> seen;

    bool is_open(std::uint32_t triangle) const {
        return triangle != none && possible[triangle] && !seen[triangle];
    }
};

/// Tests the neighbours of visible backs with more rays, then the neighbours of those that are visible, and
/// so on.
void extend_seen(const BackView& view, const std::vector<std::array<std::uint32_t, 3>>& neighbours,
                 Backs& backs) {
    std::vector<std::uint8_t> is_tested(backs.seen.size());
    std::vector<std::uint32_t> border, seen;
    for (std::uint32_t t = 0; t < backs.seen.size(); ++t)
        if (backs.seen[t]) seen.push_back(t);
    while (!seen.empty()) {
        border.clear();
        for (const std::uint32_t t : seen)
            for (const std::uint32_t n : neighbours[t])
                if (backs.is_open(n) && !is_tested[n]) {
                    is_tested[n] = 1;
                    border.push_back(n);
                }
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, border.size(), 32), [&](const auto& range) {
            for (std::size_t i = range.begin(); i != range.end(); ++i)
                backs.seen[border[i]] = view.is_seen_closely(border[i]);
        });
        seen.clear();
        std::copy_if(border.begin(), border.end(), std::back_inserter(seen),
                     [&](std::uint32_t t) { return backs.seen[t] != 0; });
    }
}

/// Marks small groups of triangles among visible backs as visible. Such a group has at most a tenth of the
/// area of all visible backs, and more edges to visible backs than other borders.
void fill_gaps(const Mesh& mesh, const std::vector<std::array<std::uint32_t, 3>>& neighbours, Backs& backs) {
    const auto area = [&](std::uint32_t t) {
        const auto& [i, j, k] = mesh.triangles[t];
        const Vec3f& a = mesh.positions[i];
        return double((mesh.positions[j] - a).cross(mesh.positions[k] - a).length());
    };
    constexpr double small = 0.1;
    double seen_area = 0;
    for (std::uint32_t t = 0; t < backs.seen.size(); ++t)
        if (backs.seen[t]) seen_area += area(t);
    std::vector<std::uint8_t> is_grouped(backs.seen.size());
    std::vector<std::uint32_t> filled;
    for (std::uint32_t first = 0; first < backs.seen.size(); ++first) {
        if (!backs.is_open(first) || is_grouped[first]) continue;
        std::vector<std::uint32_t> group{first};
        is_grouped[first] = 1;
        double group_area = 0;
        std::size_t seen_edges = 0, other_edges = 0;
        for (std::size_t i = 0; i < group.size(); ++i) {
            group_area += area(group[i]);
            for (const std::uint32_t n : neighbours[group[i]]) {
                if (n == none || !backs.possible[n])
                    ++other_edges;
                else if (backs.seen[n])
                    ++seen_edges;
                else if (!is_grouped[n]) {
                    is_grouped[n] = 1;
                    group.push_back(n);
                }
            }
        }
        if (seen_edges > other_edges && group_area <= small * seen_area)
            filled.insert(filled.end(), group.begin(), group.end());
    }
    for (const std::uint32_t t : filled) backs.seen[t] = 1;
}

/// Determines which of the possible backs are visible.
void find_seen(const Mesh& mesh, const Mesh& blocking, Backs& backs) {
    const BackView view(mesh, blocking);
    backs.seen.resize(backs.possible.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, backs.seen.size(), 256), [&](const auto& range) {
        for (std::size_t t = range.begin(); t != range.end(); ++t) {
            if (!backs.possible[t]) continue;
            backs.possible[t] = !view.has_back(t);
            backs.seen[t] = backs.possible[t] && view.is_seen(t);
        }
    });
    const auto neighbours = edge_neighbours(mesh);
    extend_seen(view, neighbours, backs);
    fill_gaps(mesh, neighbours, backs);
}

}  // namespace

Mesh seen_backs(const Mesh& mesh, const Mesh& blocking) {
    Mesh backs;
    backs.material_names = mesh.material_names;
    Backs found{triangles_of_open_pieces(mesh), {}};
    const std::vector<PieceKind> kinds = triangle_kinds(mesh);
    for (std::size_t t = 0; t < kinds.size(); ++t) found.possible[t] |= kinds[t] == PieceKind::room ? 1 : 0;
    if (std::find(found.possible.begin(), found.possible.end(), 1) == found.possible.end()) return backs;

    find_seen(mesh, blocking, found);
    std::vector<std::uint32_t> back_of(mesh.positions.size(), none);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        if (!found.seen[t]) continue;
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
