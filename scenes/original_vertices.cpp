#include "scenes/original_vertices.h"

#include "fields/mesh/mesh_topology.h"
#include "fields/mesh/polygon_triangulation.h"

#include <algorithm>
#include <cassert>
#include <map>
#include <optional>
#include <tuple>

namespace haarfield {
namespace {

/// The contribution of a vertex of the baked mesh to a vertex that the file lists.
struct Share {
    std::uint32_t listed, baked;
    double weight;
};

/// Returns the sum of the triangles' angles at each vertex. [rad]
std::vector<double> vertex_angles(const Mesh& mesh) {
    std::vector<double> angles(mesh.positions.size(), 0);
    for (const auto& triangle : mesh.triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3d at(mesh.positions[triangle[k]]);
            const Vec3d a = Vec3d(mesh.positions[triangle[(k + 1) % 3]]) - at,
                        b = Vec3d(mesh.positions[triangle[(k + 2) % 3]]) - at;
            angles[triangle[k]] += std::atan2(a.cross(b).length(), a.dot(b));
        }
    return angles;
}

/// Calls act(corners) for each face; corners are indices of positions.
template <class Act>
void for_each_face(const ListedMesh& listed, const Act& act) {
    std::span<const std::uint32_t> corners = listed.corners;
    for (const std::uint32_t count : listed.face_corners) {
        act(corners.first(count));
        corners = corners.subspan(count);
    }
}

/// Returns the sum of the area vectors of each vertex's faces; 0 without faces or area. [m^2]
std::vector<Vec3d> face_normals(const ListedMesh& listed) {
    std::vector<Vec3d> normals(listed.positions.size(), Vec3d(0, 0, 0));
    for_each_face(listed, [&](std::span<const std::uint32_t> corners) {
        Vec3d area(0, 0, 0);  // Newell's method
        for (std::size_t k = 2; k < corners.size(); ++k) {
            const Vec3d from(listed.positions[corners[0]]);
            area += (Vec3d(listed.positions[corners[k - 1]]) - from)
                        .cross(Vec3d(listed.positions[corners[k]]) - from);
        }
        if (!is_finite(Vec3f(area))) return;
        for (const std::uint32_t corner : corners) normals[corner] += area;
    });
    return normals;
}

/// Adds shares for listed vertices that no baked triangle uses, from the baked vertices at the same position.
void add_neighbours(const Mesh& surface, std::size_t fronts, const std::vector<double>& angles,
                    const ListedMesh& listed, const std::vector<std::uint32_t>& without,
                    std::vector<Share>& shares) {
    std::vector<Vec3f> places = surface.positions;
    for (const std::uint32_t vertex : without) places.push_back(listed.positions[vertex]);
    const std::vector<std::uint32_t> place = merged_positions(places).index;
    std::vector<std::vector<std::uint32_t>> wanted(places.size());  // by place
    for (std::size_t i = 0; i < without.size(); ++i)
        wanted[place[surface.positions.size() + i]].push_back(without[i]);
    std::vector<std::vector<std::uint32_t>> baked(places.size());
    for (std::uint32_t v = 0; v < surface.positions.size(); ++v)
        if (angles[v] > 0 && !wanted[place[v]].empty()) baked[place[v]].push_back(v);

    const std::vector<Vec3d> normals = face_normals(listed);
    for (std::size_t at = 0; at < places.size(); ++at)
        for (const std::uint32_t vertex : wanted[at]) {
            const auto is_on_its_side = [&](std::uint32_t v) {
                return Vec3d(surface.normals[v]).dot(normals[vertex]) > 0;
            };
            const bool has_side = std::ranges::any_of(baked[at], is_on_its_side);
            for (const std::uint32_t v : baked[at])
                if (has_side ? is_on_its_side(v) : v < fronts) shares.push_back({vertex, v, angles[v]});
        }
}

/// Returns shares of the fine mesh's vertices, which are also the vertices of the surface.
std::vector<Share> shares_of(const SceneEntity& entity) {
    assert(entity.listed);
    const ListedMesh& listed = *entity.listed;
    const Mesh surface = visible_surface(entity.mesh);  // before the two sides of thin sheets were separated
    assert(surface.positions.size() == entity.mesh.fine.positions.size());
    const std::vector<double> angles = vertex_angles(surface);
    std::vector<Share> shares;
    std::vector<bool> has_share(listed.positions.size());
    for (std::uint32_t v = 0; v < surface.positions.size(); ++v) {
        const std::int32_t number = surface.original_vertices[v];
        if (number == not_original || !(angles[v] > 0)) continue;
        const auto found = std::ranges::lower_bound(listed.numbers, number);
        if (found == listed.numbers.end() || *found != number) continue;
        const auto index = static_cast<std::uint32_t>(found - listed.numbers.begin());
        shares.push_back({index, v, angles[v]});
        has_share[index] = true;
    }
    std::vector<std::uint32_t> without;
    for (std::uint32_t v = 0; v < has_share.size(); ++v)
        if (!has_share[v] && is_finite(listed.positions[v])) without.push_back(v);
    if (!without.empty())
        add_neighbours(surface, entity.mesh.original.positions.size(), angles, listed, without, shares);
    return shares;
}

/// Returns a value per listed vertex from the values of the baked mesh's vertices; 0 without a share.
template <class ValueAt>
std::vector<Rgb> shared_out(std::span<const Share> shares, std::size_t vertices, const ValueAt& value_at) {
    std::vector<Vec3d> sums(vertices, Vec3d(0, 0, 0));
    std::vector<double> weights(vertices, 0);
    for (const auto& [listed, baked, weight] : shares) {
        sums[listed] += Vec3d(Vec3f(value_at(baked))) * weight;
        weights[listed] += weight;
    }
    std::vector<Rgb> values;
    values.reserve(vertices);
    for (std::size_t v = 0; v < vertices; ++v)
        values.push_back(weights[v] > 0 ? Rgb(Vec3f(sums[v] / weights[v])) : Rgb(0.0f));
    return values;
}

/// Returns the listed faces as a mesh. Polygons that cannot be triangulated are dropped.
Mesh mesh_of(const ListedMesh& listed, std::span<const Share> shares, const Mesh& baked) {
    Mesh mesh;
    mesh.material_names = {""};
    mesh.original_vertices = listed.numbers;
    mesh.vertex_materials.assign(listed.positions.size(), 0);
    for (const Vec3f& position : listed.positions)
        mesh.positions.push_back(is_finite(position) ? position : Vec3f(0, 0, 0));
    const std::vector<Rgb> sums =
        shared_out(shares, listed.positions.size(), [&](std::uint32_t v) { return Rgb(baked.normals[v]); });
    for (const Rgb& sum : sums) {
        const Vec3d normal{Vec3f(sum)};
        mesh.normals.push_back(normal.length2() > 1e-12 ? Vec3f(normal.normalized()) : Vec3f(0, 1, 0));
    }
    std::vector<Vec3f> polygon;
    for_each_face(listed, [&](std::span<const std::uint32_t> corners) {
        polygon.clear();
        for (const std::uint32_t corner : corners) polygon.push_back(listed.positions[corner]);
        if (polygon.size() < 3 || !std::ranges::all_of(polygon, is_finite)) return;
        for (const auto& [a, b, c] : triangulated(polygon))
            mesh.triangles.push_back({corners[a], corners[b], corners[c]});
    });
    return mesh;
}

/// A vertex of the file with one of its materials and texture coordinates.
struct MappedVertex {
    std::uint32_t listed = 0;
    std::uint16_t material = 0;
    Vec2f uv{0, 0};

    auto key() const { return std::tuple(listed, material, uv.x, uv.y); }
};

/// A mesh with texture coordinates.
struct MappedMesh {
    Mesh mesh;
    std::vector<std::uint32_t> listed;  ///< For each vertex of the mesh, the vertex of the file.
};

/// Adds the texture coordinates of the baked mesh to a mesh with the file's vertices.
class MeshMapper {
public:
    /// plain    a result of mesh_of; the baked mesh must be made of the same triangles.
    /// surface  the baked mesh; has uvs.
    MeshMapper(const Mesh& plain, std::span<const Share> shares, const Mesh& surface)
        : plain_(plain), surface_(surface), first_share_(plain.positions.size()) {
        std::vector<std::uint32_t> listed(surface.positions.size(), none);
        for (const Share& share : shares) {
            if (listed[share.baked] == none) listed[share.baked] = share.listed;
            std::optional<MappedVertex>& first = first_share_[share.listed];
            if (!first) first = mapped(share.listed, share.baked);
        }
        for (const auto& triangle : surface.triangles) {
            std::array<std::pair<std::uint32_t, std::uint32_t>, 3> corners;
            for (std::size_t k = 0; k < 3; ++k) corners[k] = {listed[triangle[k]], triangle[k]};
            std::ranges::sort(corners);
            baked_.emplace(std::array{corners[0].first, corners[1].first, corners[2].first},
                           std::array{corners[0].second, corners[1].second, corners[2].second});
        }
    }

    MappedMesh made() {
        std::vector<std::array<MappedVertex, 3>> triangles;
        for (const auto& triangle : plain_.triangles) triangles.push_back(corners_of(triangle));
        // Each vertex of the file keeps its index for its first material and coordinates.
        std::vector<std::optional<MappedVertex>> own = first_share_;
        std::vector<bool> is_used(own.size());
        for (const auto& triangle : triangles)
            for (const MappedVertex& corner : triangle)
                if (!is_used[corner.listed]) {
                    own[corner.listed] = corner;
                    is_used[corner.listed] = true;
                }
        result_.mesh = plain_;
        result_.mesh.triangles.clear();
        result_.mesh.material_names = surface_.material_names;
        for (std::uint32_t v = 0; v < own.size(); ++v) {
            const MappedVertex vertex = own[v].value_or(MappedVertex{v});
            result_.mesh.vertex_materials[v] = vertex.material;
            result_.mesh.uvs.push_back(vertex.uv);
            result_.listed.push_back(v);
            index_.emplace(vertex.key(), v);
        }
        for (const auto& [a, b, c] : triangles)
            result_.mesh.triangles.push_back({index_of(a), index_of(b), index_of(c)});
        return std::move(result_);
    }

private:
    static constexpr std::uint32_t none = ~0u;

    MappedVertex mapped(std::uint32_t listed, std::uint32_t baked) const {
        return {listed, surface_.vertex_materials[baked], surface_.uvs[baked]};
    }

    /// Returns the corners of the baked triangle. If the triangle was not baked, each corner is that of the
    /// first baked triangle at its vertex.
    std::array<MappedVertex, 3> corners_of(const std::array<std::uint32_t, 3>& triangle) const {
        std::array<std::uint32_t, 3> sorted = triangle;
        std::ranges::sort(sorted);
        const auto found = baked_.find(sorted);
        std::array<MappedVertex, 3> corners;
        for (std::size_t k = 0; k < 3; ++k) {
            if (found != baked_.end()) {
                const auto at = std::ranges::find(sorted, triangle[k]) - sorted.begin();
                corners[k] = mapped(triangle[k], found->second[std::size_t(at)]);
            } else {
                corners[k] = first_share_[triangle[k]].value_or(MappedVertex{triangle[k]});
                corners[k].material = corners[0].material;  // a triangle has one material
            }
        }
        return corners;
    }

    std::uint32_t index_of(const MappedVertex& vertex) {
        const auto [found, is_new] =
            index_.emplace(vertex.key(), static_cast<std::uint32_t>(result_.mesh.positions.size()));
        if (is_new) {
            result_.mesh.copy_vertex(vertex.listed);
            result_.mesh.vertex_materials.back() = vertex.material;
            result_.mesh.uvs.back() = vertex.uv;
            result_.listed.push_back(vertex.listed);
        }
        return found->second;
    }

    const Mesh& plain_;
    const Mesh& surface_;
    std::vector<std::optional<MappedVertex>> first_share_;  ///< By the file's vertices.
    /// The corners of the baked triangles, by their vertices in the file in ascending order.
    std::map<std::array<std::uint32_t, 3>, std::array<std::uint32_t, 3>> baked_;
    std::map<std::tuple<std::uint32_t, std::uint16_t, float, float>, std::uint32_t> index_;
    MappedMesh result_;
};

/// Returns the light of a mesh with texture coordinates. Each vertex averages the baked vertices with its
/// material, because an image multiplies the light of one material only. Without such vertices, it averages
/// all baked vertices.
template <class ValueAt>
std::vector<Rgb> mapped_light(const Mesh& mesh, std::span<const std::uint32_t> mesh_listed,
                              std::span<const Share> shares, const Mesh& baked, const ValueAt& value_at) {
    std::map<std::pair<std::uint32_t, std::uint16_t>, std::pair<Vec3d, double>> sums;
    for (const auto& [listed, vertex, weight] : shares) {
        auto& [sum, weights] =
            sums.try_emplace({listed, baked.vertex_materials[vertex]}, Vec3d(0, 0, 0), 0.0).first->second;
        sum += Vec3d(Vec3f(value_at(vertex))) * weight;
        weights += weight;
    }
    const std::vector<Rgb> of_all = shared_out(shares, mesh_listed.size(), value_at);
    std::vector<Rgb> light;
    for (std::size_t v = 0; v < mesh_listed.size(); ++v) {
        const auto found = sums.find({mesh_listed[v], mesh.vertex_materials[v]});
        light.push_back(found == sums.end() ? of_all[mesh_listed[v]]
                                            : Rgb(Vec3f(found->second.first / found->second.second)));
    }
    return light;
}

std::size_t unvalued(std::span<const Share> shares, std::size_t vertices) {
    std::vector<bool> has_share(vertices);
    for (const Share& share : shares) has_share[share.listed] = true;
    return static_cast<std::size_t>(std::ranges::count(has_share, false));
}

}  // namespace

OriginalBake original_bake(const SceneEntities& entities, std::span<const BakedInstance> instances,
                           bool with_images) {
    OriginalBake bake;
    std::vector<std::vector<Share>> shares;
    std::vector<std::vector<std::uint32_t>> mapped_vertices;  // by entity: MappedMesh::listed
    for (const auto& entity : entities.entities) {
        shares.push_back(shares_of(*entity));
        bake.meshes.push_back(mesh_of(*entity->listed, shares.back(), entity->mesh.fine));
        if (!with_images) continue;
        MappedMesh mapped;
        if (has_textures(entity->surfaces))
            mapped = MeshMapper(bake.meshes.back(), shares.back(), entity->mesh.fine).made();
        bake.textured_meshes.push_back(std::move(mapped.mesh));
        mapped_vertices.push_back(std::move(mapped.listed));
    }
    for (std::size_t i = 0; i < instances.size(); ++i) {
        const BakedInstance& baked = instances[i];
        const std::size_t e = entities.entity_of_instance[i], vertices = bake.meshes[e].positions.size();
        const auto stored = [&](std::vector<Rgb> values) -> std::span<const Rgb> {
            return bake.values.emplace_back(std::move(values));
        };
        const auto values_of = [&](const auto& value_at) {
            return stored(shared_out(shares[e], vertices, value_at));
        };
        BakedInstance& original = bake.instances.emplace_back();
        original.name = baked.name;
        original.mesh = &bake.meshes[e];
        original.placement = baked.placement;
        original.radiance = values_of([&](std::uint32_t v) { return displayed_radiance(baked, v); });
        for (const VertexValues& pass : baked.passes)
            original.passes.push_back(
                {pass.name, values_of([&](std::uint32_t v) { return pass.values[v]; }), pass.is_scalar});
        original.listed = &*entities.entities[e]->listed;
        bake.vertices += vertices;
        bake.unvalued += unvalued(shares[e], vertices);

        if (!with_images) continue;
        BakedInstance& textured = bake.textured.emplace_back(original);
        if (!has_textures(baked.surfaces)) continue;
        const auto light_of = [&](std::span<const Rgb> values) {
            return stored(mapped_light(bake.textured_meshes[e], mapped_vertices[e], shares[e], *baked.mesh,
                                       [&](std::uint32_t v) { return values[v]; }));
        };
        textured.mesh = &bake.textured_meshes[e];
        textured.listed = nullptr;
        textured.surfaces = baked.surfaces;
        textured.radiance = light_of(baked.radiance);
        if (!baked.added.empty()) textured.added = light_of(baked.added);
        for (VertexValues& pass : textured.passes) {
            std::vector<Rgb> values;
            for (const std::uint32_t v : mapped_vertices[e]) values.push_back(pass.values[v]);
            pass.values = stored(std::move(values));
        }
    }
    return bake;
}

}  // namespace haarfield
