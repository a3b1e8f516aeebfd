#pragma once
/// The container that readers of mesh files fill.

#include "fields/base/names.h"
#include "fields/base/range.h"
#include "fields/mesh/mesh.h"
#include "fields/mesh/polygon_triangulation.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <set>

namespace haarfield {

/// Faces and vertices as in a file. Missing normals are zero.
struct FaceGatherer {
    Mesh mesh{};
    std::vector<MeshMaterial> descriptions{};  // by material
    std::vector<bool> mapped{}, coloured{};    // by material: true if vertices have uvs or colours
    std::map<std::string, std::size_t> unused{};
    MeshFindings findings{};
    std::set<std::string> names{};                        // names of materials
    std::map<std::string, std::uint16_t> by_name{};       // materials without properties
    std::set<std::array<std::uint32_t, 3>> non_finite{};  // as bits: a vertex may occur several times
    bool too_large = false;
    std::int32_t listed = 0;  // number of vertices of the file so far: the index of the next

    /// Tests whether `vertices` more vertices fit. If not, the file is too large.
    bool has_room_for(std::size_t vertices) {
        too_large |= mesh.positions.size() + vertices > INT32_MAX || mesh.material_names.size() > 60000;
        return !too_large;
    }

    /// Adds a material. Further materials with the same name become `name (2)` and so on.
    std::uint16_t new_material(const std::string& name, const MeshMaterial& description) {
        const auto number = static_cast<std::uint16_t>(mesh.material_names.size());
        mesh.material_names.push_back(unique_name(name, names, " (", ")"));
        descriptions.push_back(description);
        mapped.push_back(false);
        coloured.push_back(false);
        return number;
    }

    /// Returns a material of which the file contains only the name.
    std::uint16_t material_named(const std::string& name) {
        const auto [known, is_new] = by_name.try_emplace(name, std::uint16_t(0));
        if (is_new) known->second = new_material(name, {});
        return known->second;
    }

    /// Adds a vertex with uv (0, 0) and colour white.
    ///
    /// number  of the vertex in the file: see ListedMesh.
    void add_vertex(const Vec3f& position, const Vec3d& normal, std::uint16_t material, std::int32_t number) {
        if (!is_finite(position))
            non_finite.insert({std::bit_cast<std::uint32_t>(position.x),
                               std::bit_cast<std::uint32_t>(position.y),
                               std::bit_cast<std::uint32_t>(position.z)});
        else if (std::max({std::abs(position.x), std::abs(position.y), std::abs(position.z)}) >
                 static_cast<float>(coordinates.highest))
            too_large = true;
        mesh.positions.push_back(position);
        const double length = normal.length();
        mesh.normals.push_back(std::isfinite(length) && length > 0 ? Vec3f(normal / length) : Vec3f(0, 0, 0));
        mesh.vertex_materials.push_back(material);
        mesh.uvs.emplace_back(0.0f, 0.0f);
        mesh.colours.emplace_back(1.0f);
        mesh.original_vertices.push_back(number);
    }

    /// Counts vertices of the file, whether they were added or not.
    void pass_vertices(std::size_t count) {
        if (count > static_cast<std::size_t>(INT32_MAX - listed))
            too_large = true;
        else
            listed += static_cast<std::int32_t>(count);
    }

    /// Sets the uv of the last vertex. Coordinates that are too large are ignored.
    void set_uv(const Vec2f& uv) {
        // At larger coordinates, a float cannot distinguish adjacent texels.
        constexpr float farthest = 1e4f;
        mapped[mesh.vertex_materials.back()] = true;
        if (std::abs(uv.x) <= farthest && std::abs(uv.y) <= farthest) mesh.uvs.back() = uv;
    }
    /// Sets the colour of the last vertex, clamped to [0, 1]. NaN becomes 0.
    void set_colour(const Rgb& colour) {
        const auto clean = [](float channel) { return channel >= 0 ? std::min(channel, 1.0f) : 0.0f; };
        mesh.colours.back() = Rgb(clean(colour.x), clean(colour.y), clean(colour.z));
        coloured[mesh.vertex_materials.back()] = true;
    }

    /// Adds a polygon. corners: counted from `first`. Skipped if there are fewer than three, or if one is not
    /// a finite vertex.
    void add_face(std::span<const std::uint32_t> corners, std::uint32_t first) {
        if (corners.size() < 3) return;  // points and lines
        polygon_.clear();
        for (const std::uint32_t corner : corners) {
            if (corner >= mesh.positions.size() - first) return;
            polygon_.push_back(mesh.positions[first + corner]);
            if (!is_finite(polygon_.back())) return;
        }
        if (polygon_.size() > 3) ++findings.polygons;
        for (const auto& t : triangulated(polygon_))
            mesh.triangles.push_back({first + corners[t[0]], first + corners[t[1]], first + corners[t[2]]});
    }

private:
    std::vector<Vec3f> polygon_;
};

}  // namespace haarfield
