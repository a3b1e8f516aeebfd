#pragma once
/// A triangle mesh as it is baked, and what was found wrong with it on the way in.

#include "fields/base/vector.h"
#include "fields/mesh/mesh_material.h"

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace haarfield {

/// An axis-aligned box. Empty (lower > upper) until a point is added. [m]
struct Bounds {
    Vec3f lower{INFINITY, INFINITY, INFINITY};
    Vec3f upper{-INFINITY, -INFINITY, -INFINITY};

    Vec3f centre() const { return (lower + upper) * 0.5f; }           ///< The box's middle. [m]
    float radius() const { return (upper - lower).length() * 0.5f; }  ///< Of the sphere round the box.

    /// Grows to hold a point, or a sphere round it.
    void add(const Vec3f& point, float around = 0) {
        for (int axis = 0; axis < 3; ++axis) {
            lower[axis] = std::min(lower[axis], point[axis] - around);
            upper[axis] = std::max(upper[axis], point[axis] + around);
        }
    }
};

/// The number of a vertex that no file has: one that was made.
inline constexpr std::int32_t not_original = -1;

/// A triangle mesh with one normal and one material per vertex: where normals or materials part,
/// the position is there more than once.
struct Mesh {
    std::vector<Vec3f> positions;                         ///< [m], finite.
    std::vector<Vec3f> normals;                           ///< One per position; unit length.
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< Counter-clockwise seen from outside.
    std::vector<std::uint16_t> vertex_materials;          ///< One per position: index in material_names.
    std::vector<std::string> material_names;              ///< As named in the file; at least one ("").
    /// Where the image of its material shows at a vertex; one per position, or none if no image is used.
    std::vector<Vec2f> uvs;
    /// Of vertices, linear, to be multiplied with their material's diffuse term; one per position, or none.
    std::vector<Rgb> colours;
    /// Which of the vertices that its file lists (ListedMesh::numbers) each is, the first where several are
    /// alike; not_original: none of them. One per position, or none if the mesh is of no file.
    std::vector<std::int32_t> original_vertices;

    /// Adds a copy of a vertex, with the index of the copy.
    std::uint32_t copy_vertex(std::uint32_t vertex);
};

Bounds bounds_of(std::span<const Vec3f> points);  ///< The box round all of them.
Bounds mesh_bounds(const Mesh& mesh);             ///< The box round all positions.

/// Adds a mesh with the same materials behind what is there. Of two meshes, one of which is of no file, the
/// vertices of that one are not_original.
void append_mesh(Mesh& mesh, const Mesh& added);

/// What was found in a mesh file, and mended where it could be.
struct MeshFindings {
    std::uint64_t polygons = 0;              ///< Faces with more than three corners; triangulated.
    std::uint64_t non_finite_vertices = 0;   ///< Left out, with the faces that use them.
    std::uint64_t duplicate_vertices = 0;    ///< At the place of another one; merged for topology.
    std::uint64_t degenerate_triangles = 0;  ///< Without area; left out.
    std::uint64_t duplicate_triangles = 0;   ///< Left out.
    std::uint64_t non_manifold_edges = 0;    ///< Shared by more than two triangles; kept.
    std::uint64_t boundary_edges = 0;        ///< With one triangle only: the surface is open there.
    std::uint64_t flipped_triangles = 0;     ///< Turned round, to agree with their neighbours.
    std::uint64_t components = 0;            ///< Connected pieces, by shared positions.
    std::uint64_t open_components = 0;       ///< Of these, not closed.
    std::uint64_t parted_vertices = 0;       ///< Of sheets without thickness, moved apart; see thin_sheets.h.
    std::uint64_t backs = 0;                 ///< Triangles baked from both sides; see sheet_backs.h.
    bool self_intersecting = false;          ///< One piece by itself; pieces may cross each other.

    /// One line for a person, such as "312 n-gons triangulated, 18 open edges in 2 of 5 pieces";
    /// empty if there is nothing to say.
    std::string summary() const;
};

}  // namespace haarfield
