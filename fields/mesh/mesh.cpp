#include "fields/mesh/mesh.h"

#include <fmt/format.h>
#include <algorithm>

namespace haarfield {

namespace {

std::string counted(std::uint64_t count, const char* one, const char* many) {
    return fmt::format("{} {}", count, count == 1 ? one : many);
}

}  // namespace

std::uint32_t Mesh::copy_vertex(std::uint32_t vertex) {
    const auto copy = static_cast<std::uint32_t>(positions.size());
    positions.push_back(Vec3f(positions[vertex]));
    normals.push_back(Vec3f(normals[vertex]));
    vertex_materials.push_back(std::uint16_t(vertex_materials[vertex]));
    if (!uvs.empty()) uvs.push_back(Vec2f(uvs[vertex]));
    if (!colours.empty()) colours.push_back(Rgb(colours[vertex]));
    if (!original_vertices.empty()) original_vertices.push_back(std::int32_t(original_vertices[vertex]));
    return copy;
}

Bounds bounds_of(std::span<const Vec3f> points) {
    Bounds bounds;
    for (const Vec3f& p : points) bounds.add(p);
    return bounds;
}

Bounds mesh_bounds(const Mesh& mesh) {
    return bounds_of(mesh.positions);
}

void append_mesh(Mesh& mesh, const Mesh& added) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    if (!mesh.original_vertices.empty() || !added.original_vertices.empty()) {
        mesh.original_vertices.resize(mesh.positions.size(), not_original);
        mesh.original_vertices.insert(mesh.original_vertices.end(), added.original_vertices.begin(),
                                      added.original_vertices.end());
        mesh.original_vertices.resize(mesh.positions.size() + added.positions.size(), not_original);
    }
    mesh.positions.insert(mesh.positions.end(), added.positions.begin(), added.positions.end());
    mesh.normals.insert(mesh.normals.end(), added.normals.begin(), added.normals.end());
    mesh.vertex_materials.insert(mesh.vertex_materials.end(), added.vertex_materials.begin(),
                                 added.vertex_materials.end());
    mesh.uvs.insert(mesh.uvs.end(), added.uvs.begin(), added.uvs.end());
    mesh.colours.insert(mesh.colours.end(), added.colours.begin(), added.colours.end());
    for (const auto& t : added.triangles)
        mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
}

std::string MeshFindings::summary() const {
    std::string text;
    const auto add = [&text](const std::string& finding) { text += (text.empty() ? "" : ", ") + finding; };
    if (polygons) add(counted(polygons, "n-gon", "n-gons") + " triangulated");
    if (non_finite_vertices) add(counted(non_finite_vertices, "vertex", "vertices") + " not finite, removed");
    if (degenerate_triangles)
        add(counted(degenerate_triangles, "triangle", "triangles") + " without area removed");
    if (duplicate_triangles)
        add(counted(duplicate_triangles, "duplicate triangle", "duplicate triangles") + " removed");
    if (flipped_triangles) add(counted(flipped_triangles, "triangle", "triangles") + " reversed");
    if (non_manifold_edges)
        add(counted(non_manifold_edges, "edge", "edges") + " shared by more than two triangles");
    if (boundary_edges)
        add(counted(boundary_edges, "open edge", "open edges") +
            (components == 1 ? " in its only piece"
                             : fmt::format(" in {} of {} pieces", open_components, components)));
    if (backs) add(counted(backs, "triangle", "triangles") + " of sheets baked from both sides");
    if (parted_vertices) add("sheets without thickness separated into two sides");
    if (self_intersecting) add("a piece intersects itself");
    return text;
}

}  // namespace haarfield
