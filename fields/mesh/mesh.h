#pragma once
/// Triangle meshes, and the defects that were found in them.

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

    Vec3f centre() const { return (lower + upper) * 0.5f; }           ///< Centre of the box. [m]
    float radius() const { return (upper - lower).length() * 0.5f; }  ///< Radius of the circumscribed sphere.

    /// Extends the box by a point, or by a sphere around it.
    void add(const Vec3f& point, float around = 0) {
        for (int axis = 0; axis < 3; ++axis) {
            lower[axis] = std::min(lower[axis], point[axis] - around);
            upper[axis] = std::max(upper[axis], point[axis] + around);
        }
    }
};

/// The number of a vertex that does not occur in the file.
inline constexpr std::int32_t not_original = -1;

/// A triangle mesh with one normal and one material per vertex. If normals or materials differ at a position,
/// the position occurs several times.
struct Mesh {
    std::vector<Vec3f> positions;                         ///< [m], finite.
    std::vector<Vec3f> normals;                           ///< One per position; unit length.
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< Counter-clockwise as viewed from outside.
    std::vector<std::uint16_t> vertex_materials;          ///< One per position: index in material_names.
    std::vector<std::string> material_names;              ///< As named in the file; at least one ("").
    /// Texture coordinates in the image of the vertex's material; one per position, or none if no image is
    /// used.
    std::vector<Vec2f> uvs;
    /// Linear vertex colours, which multiply the material's diffuse term; one per position, or none.
    std::vector<Rgb> colours;
    /// The number of each vertex in its file (ListedMesh::numbers), the first if several are equal, or
    /// not_original. One per position, or none if the mesh is not from a file.
    std::vector<std::int32_t> original_vertices;

    /// Appends a copy of a vertex. Returns its index.
    std::uint32_t copy_vertex(std::uint32_t vertex);
};

Bounds bounds_of(std::span<const Vec3f> points);  ///< The bounding box of points.
Bounds mesh_bounds(const Mesh& mesh);             ///< The bounding box of all positions.

/// Appends a mesh with the same materials. If only one of the meshes has original_vertices, those of the
/// other become not_original.
void append_mesh(Mesh& mesh, const Mesh& added);

/// Defects found in a mesh file, and their repairs.
struct MeshFindings {
    std::uint64_t polygons = 0;              ///< Faces with more than three corners; triangulated.
    std::uint64_t non_finite_vertices = 0;   ///< Removed, with the faces that use them.
    std::uint64_t duplicate_vertices = 0;    ///< At the position of another vertex; merged for topology.
    std::uint64_t degenerate_triangles = 0;  ///< Without area; removed.
    std::uint64_t duplicate_triangles = 0;   ///< Removed.
    std::uint64_t non_manifold_edges = 0;    ///< Shared by more than two triangles; kept.
    std::uint64_t boundary_edges = 0;        ///< With one triangle: the surface is open there.
    std::uint64_t flipped_triangles = 0;     ///< Reversed, to agree with their neighbours.
    std::uint64_t components = 0;            ///< Pieces connected by shared positions.
    std::uint64_t open_components = 0;       ///< Those that are not closed.
    std::uint64_t parted_vertices = 0;       ///< In sheets without thickness; separated, see thin_sheets.h.
    std::uint64_t backs = 0;                 ///< Triangles baked from both sides; see sheet_backs.h.
    bool self_intersecting = false;          ///< Within one piece; different pieces may cross each other.

    /// Returns a one-line summary, such as "312 n-gons triangulated, 18 open edges in 2 of 5 pieces"; empty
    /// if there are no findings.
    std::string summary() const;
};

}  // namespace haarfield
