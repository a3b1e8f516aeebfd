#include "fields/mesh.h"

#include <fmt/format.h>
#include <algorithm>

namespace haarfield {

namespace {

std::string counted(std::uint64_t count, const char* one, const char* many) {
    return fmt::format("{} {}", count, count == 1 ? one : many);
}

}  // namespace

Bounds mesh_bounds(const Mesh& mesh) {
    Bounds bounds;
    for (const Vec3f& p : mesh.positions)
        for (int axis = 0; axis < 3; ++axis) {
            bounds.lower[axis] = std::min(bounds.lower[axis], p[axis]);
            bounds.upper[axis] = std::max(bounds.upper[axis], p[axis]);
        }
    return bounds;
}

std::string MeshFindings::summary() const {
    std::string text;
    const auto add = [&text](const std::string& finding) { text += (text.empty() ? "" : ", ") + finding; };
    if (polygons) add(counted(polygons, "n-gon", "n-gons") + " triangulated");
    if (non_finite_vertices)
        add(counted(non_finite_vertices, "vertex", "vertices") + " not finite, left out");
    if (degenerate_triangles)
        add(counted(degenerate_triangles, "triangle", "triangles") + " without area left out");
    if (duplicate_triangles)
        add(counted(duplicate_triangles, "duplicate triangle", "duplicate triangles") + " left out");
    if (flipped_triangles) add(counted(flipped_triangles, "triangle", "triangles") + " turned round");
    if (non_manifold_edges)
        add(counted(non_manifold_edges, "edge", "edges") + " shared by more than two triangles");
    if (boundary_edges)
        add(counted(boundary_edges, "open edge", "open edges") +
            (components == 1 ? " in its only piece"
                             : fmt::format(" in {} of {} pieces", open_components, components)));
    if (parted_vertices) add("sheets without thickness, their two sides parted");
    if (self_intersecting) add("a piece intersects itself");
    return text;
}

}  // namespace haarfield
