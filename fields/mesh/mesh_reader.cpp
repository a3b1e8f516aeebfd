#include "fields/mesh/mesh_reader.h"

#include "fields/base/range.h"
#include "fields/file/mapped_file.h"
#include "fields/mesh/mesh2_file.h"
#include "fields/mesh/mesh_topology.h"
#include "fields/mesh/obj_leading_zeros.h"
#include "fields/mesh/polygon_file.h"
#include "fields/mesh/polygon_triangulation.h"

#include <assimp/DefaultIOSystem.h>
#include <assimp/MemoryIOWrapper.h>
#include <assimp/material.h>
#include <assimp/scene.h>
#include <algorithm>
#include <assimp/Importer.hpp>
#include <bit>
#include <cctype>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <sstream>
#include <system_error>
#include <unordered_map>

namespace haarfield {

namespace {

using Triangle = std::array<std::uint32_t, 3>;

/// The file system, but for one file, whose text was mended.
///
/// The text outlives the streams over it, as assimp closes them before it lets go of the system.
class ObjIoSystem : public Assimp::DefaultIOSystem {
public:
    ObjIoSystem(const std::filesystem::path& file, std::string text)
        : file_(file.string()), text_(std::move(text)) {}

    Assimp::IOStream* Open(const char* name, const char* mode) override {
        if (file_ == name && mode[0] == 'r')
            return new Assimp::MemoryIOStream(reinterpret_cast<const std::uint8_t*>(text_.data()),
                                              text_.size());
        return DefaultIOSystem::Open(name, mode);
    }

private:
    std::string file_, text_;
};

/// The name's ending in lower case, with its point.
std::string ending_of(const std::filesystem::path& file) {
    std::string ending = file.extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](unsigned char c) { return std::tolower(c); });
    return ending;
}

std::unique_ptr<Assimp::IOSystem> file_system_for(const std::filesystem::path& file) {
    if (ending_of(file) != ".obj") return std::make_unique<Assimp::DefaultIOSystem>();
    std::ifstream stream(file, std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
    std::string mended = with_leading_zeros(text);
    if (!stream || mended == text) return std::make_unique<Assimp::DefaultIOSystem>();
    return std::make_unique<ObjIoSystem>(file, std::move(mended));
}

constexpr const char* wanted_endings =
    ", which nothing here reads; wanted .obj, .ply, .gltf, .glb, .stl, .off, .inc, .pov or another of "
    "assimp's formats";

Vec3f vector_from(const aiVector3D& v) {
    return {v.x, v.y, v.z};
}

/// All faces of a file, each vertex as it is there; normals are zero where there are none.
struct Gatherer {
    Mesh mesh{};
    MeshFindings findings{};
    std::map<std::string, std::uint16_t> materials{};
    std::set<std::array<std::uint32_t, 3>> non_finite{};  // by bits: one vertex may come many times
    bool too_large = false;

    /// Whether so many more vertices fit; if not, the file is too large.
    bool has_room_for(std::size_t vertices) {
        too_large |= mesh.positions.size() + vertices > INT32_MAX || mesh.material_names.size() > 60000;
        return !too_large;
    }

    std::uint16_t material_named(const std::string& name) {
        const auto [found, is_new] =
            materials.try_emplace(name, static_cast<std::uint16_t>(mesh.material_names.size()));
        if (is_new) mesh.material_names.push_back(name);
        return found->second;
    }

    void add_vertex(const Vec3f& position, const Vec3d& normal, std::uint16_t material) {
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
    }

    /// corners  from `first` on; passed over if there are fewer than three, or one that is no finite vertex.
    void add_face(std::span<const std::uint32_t> corners, std::uint32_t first) {
        if (corners.size() < 3) return;  // points and lines
        polygon_.clear();
        for (const std::uint32_t corner : corners) {
            if (corner >= mesh.positions.size() - first) return;
            polygon_.push_back(mesh.positions[first + corner]);
            if (!is_finite(polygon_.back())) return;
        }
        if (polygon_.size() > 3) ++findings.polygons;
        for (const Triangle& t : triangulated(polygon_))
            mesh.triangles.push_back({first + corners[t[0]], first + corners[t[1]], first + corners[t[2]]});
    }

    void add(const PolygonFile& file) {
        if (!has_room_for(file.positions.size())) return;
        const std::uint16_t material = material_named("");
        for (std::size_t v = 0; v < file.positions.size(); ++v)
            add_vertex(file.positions[v], file.normals.empty() ? Vec3d(0, 0, 0) : Vec3d(file.normals[v]),
                       material);
        std::span<const std::uint32_t> corners = file.corners;
        for (const std::uint32_t count : file.face_corners) {
            add_face(corners.first(count), 0);
            corners = corners.subspan(count);
        }
    }

    /// Each mesh where it stands, every corner a vertex of its own.
    void add(const Mesh2File& file) {
        for (const PlacedMesh2& placed : file.placed) {
            const Mesh2& part = file.meshes[placed.mesh];
            if (!has_room_for(3 * part.faces.size())) return;
            Mesh2Materials named(file, placed);
            const bool mirrored = placed.transform.is_mirrored();
            for (const Mesh2Face& face : part.faces) {
                const std::uint16_t material = named.of(face, *this);
                if (!has_room_for(0)) return;
                const auto first = static_cast<std::uint32_t>(mesh.positions.size());
                for (std::size_t k = 0; k < 3; ++k) {
                    const Vec3d position(part.positions[face.positions[k]]);
                    Vec3d normal(0, 0, 0);
                    if (face.normals[k] != Mesh2Face::none)
                        normal = placed.transform.normal(Vec3d(part.normals[face.normals[k]]));
                    add_vertex(Vec3f(placed.transform.point(position)), normal, material);
                }
                constexpr std::array<std::uint32_t, 3> as_it_is{0, 1, 2}, turned{0, 2, 1};
                add_face(mirrored ? turned : as_it_is, first);
            }
        }
    }

private:
    /// What the faces of a mesh2 are made of, found once for each texture.
    class Mesh2Materials {
    public:
        Mesh2Materials(const Mesh2File& file, const PlacedMesh2& placed)
            : mesh_(file.meshes[placed.mesh]), is_alone_(file.meshes.size() == 1) {
            whole_ = !mesh_.material.empty()    ? mesh_.material
                     : !placed.material.empty() ? placed.material
                     : is_alone_                ? ""
                                                : mesh_.name;
            const auto is_blended = [](const Mesh2Face& face) {
                return face.textures[1] != face.textures[0] || face.textures[2] != face.textures[0];
            };
            // Colours of vertices, not materials.
            has_colours_ = std::any_of(mesh_.faces.begin(), mesh_.faces.end(), is_blended);
            is_plain_ = mesh_.textures.size() == 1;
            of_texture_.assign(mesh_.textures.size(), unknown);
        }

        std::uint16_t of(const Mesh2Face& face, Gatherer& gatherer) {
            const std::uint32_t texture = face.textures[0];
            std::uint32_t& known = texture == Mesh2Face::none ? of_whole_ : of_texture_[texture];
            if (known == unknown) known = gatherer.material_named(name_of(texture));
            return static_cast<std::uint16_t>(known);
        }

    private:
        static constexpr std::uint32_t unknown = UINT32_MAX;

        std::string name_of(std::uint32_t texture) const {
            if (texture == Mesh2Face::none) return whole_;
            if (!mesh_.textures[texture].empty()) return mesh_.textures[texture];
            if (has_colours_ || is_plain_) return whole_;
            return (is_alone_ ? "" : mesh_.name + " ") + std::to_string(texture);
        }

        const Mesh2& mesh_;
        bool is_alone_, has_colours_ = false, is_plain_ = false;
        std::string whole_;
        std::vector<std::uint32_t> of_texture_;
        std::uint32_t of_whole_ = unknown;
    };

    std::vector<Vec3f> polygon_;
};

/// What assimp has read, put into a Gatherer.
struct SceneGatherer {
    const aiScene& scene;
    Gatherer& gatherer;

    std::uint16_t material_of(const aiMesh& part) {
        std::string name;
        aiString text;
        if (part.mMaterialIndex < scene.mNumMaterials &&
            scene.mMaterials[part.mMaterialIndex]->Get(AI_MATKEY_NAME, text) == aiReturn_SUCCESS)
            name = text.C_Str();
        return gatherer.material_named(name == AI_DEFAULT_MATERIAL_NAME ? "" : name);
    }

    void add(const aiMesh& part, const aiMatrix4x4& transform) {
        if (!part.HasFaces() || !part.HasPositions() || !gatherer.has_room_for(part.mNumVertices)) return;
        Mesh& mesh = gatherer.mesh;
        const std::uint32_t first = static_cast<std::uint32_t>(mesh.positions.size());
        const std::size_t first_triangle = mesh.triangles.size();
        const std::uint16_t material = material_of(part);
        aiMatrix3x3 for_normals(transform);
        const bool mirrored = for_normals.Determinant() < 0;
        for_normals.Inverse().Transpose();
        for (unsigned i = 0; i < part.mNumVertices; ++i)
            gatherer.add_vertex(
                vector_from(transform * part.mVertices[i]),
                part.HasNormals() ? Vec3d(vector_from(for_normals * part.mNormals[i])) : Vec3d(0, 0, 0),
                material);
        for (unsigned i = 0; i < part.mNumFaces; ++i)
            gatherer.add_face({part.mFaces[i].mIndices, part.mFaces[i].mNumIndices}, first);
        if (mirrored)
            for (std::size_t t = first_triangle; t < mesh.triangles.size(); ++t)
                std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
    }

    void add_nodes() {
        std::vector<std::pair<const aiNode*, aiMatrix4x4>> open;
        if (scene.mRootNode) open.emplace_back(scene.mRootNode, scene.mRootNode->mTransformation);
        while (!open.empty() && !gatherer.too_large) {
            const auto [node, transform] = open.back();
            open.pop_back();
            for (unsigned i = 0; i < node->mNumMeshes; ++i)
                if (node->mMeshes[i] < scene.mNumMeshes) add(*scene.mMeshes[node->mMeshes[i]], transform);
            for (unsigned i = node->mNumChildren; i-- > 0;)  // so that they come off in order
                open.emplace_back(node->mChildren[i], transform * node->mChildren[i]->mTransformation);
        }
    }
};

/// Whether the pieces of a GLB file are as long as they say: assimp makes room for them before it looks.
bool has_whole_chunks(std::string_view glb) {
    constexpr std::size_t file_head = 12, chunk_head = 8;
    std::size_t at = file_head;
    while (at + chunk_head <= glb.size()) {
        std::uint32_t length = 0;
        std::memcpy(&length, glb.data() + at, sizeof length);
        at += chunk_head;
        if (length > glb.size() - at) return false;
        at += length;
    }
    return true;
}

/// By the ending of its name; where no reader knows that, by a look into the file.
bool holds_mesh2(const std::filesystem::path& file, const std::string& ending) {
    if (ending == ".inc" || ending == ".pov" || ending == ".mesh2") return true;
    if (Assimp::Importer().IsExtensionSupported(ending)) return false;
    const Result<MappedFile> mapped = mapped_file(file);
    return mapped && mentions_mesh2(mapped->bytes);
}

/// All faces of a file. errors (with an empty `where`) what its reader says.
Result<Gatherer> gathered_faces(const std::filesystem::path& file) {
    Gatherer gatherer;
    const std::string ending = ending_of(file);
    if (holds_mesh2(file, ending)) {
        const Result<MappedFile> mapped = mapped_file(file);
        if (!mapped) return Error{"", mapped.error().what};
        const Result<Mesh2File> meshes = read_mesh2(mapped->bytes);
        if (!meshes) return meshes.error();
        gatherer.add(*meshes);
    } else if (ending == ".ply" || ending == ".off") {
        const Result<MappedFile> mapped = mapped_file(file);
        if (!mapped) return Error{"", mapped.error().what};
        const Result<PolygonFile> polygons =
            ending == ".ply" ? read_ply(mapped->bytes) : read_off(mapped->bytes);
        if (!polygons) return polygons.error();
        gatherer.add(*polygons);
    } else {
        if (ending == ".glb") {
            const Result<MappedFile> mapped = mapped_file(file);
            if (!mapped) return Error{"", mapped.error().what};
            if (!has_whole_chunks(mapped->bytes)) return Error{"", "a chunk is longer than the file"};
        }
        Assimp::Importer importer;
        if (!importer.IsExtensionSupported(ending))
            return Error{"",
                         (ending.empty() ? "has no ending" : "has the ending " + ending) + wanted_endings};
        importer.SetIOHandler(file_system_for(file).release());  // the importer's own from here on
        // no post-processing: it would take indices and coordinates on trust
        const aiScene* scene = importer.ReadFile(file.string(), 0);
        if (!scene) return Error{"", importer.GetErrorString()};
        SceneGatherer{*scene, gatherer}.add_nodes();
    }
    gatherer.findings.non_finite_vertices = gatherer.non_finite.size();
    return gatherer;
}

/// Corners at one position whose triangles face one way.
struct FacetGroup {
    Vec3d normal;                      ///< Unit normal of the first.
    std::span<std::uint32_t> corners;  ///< 3 * triangle + corner.
    Vec3d sum{0, 0, 0};                ///< Of their weighted normals.
};

/// Groups of one corner each; at a fan of very many, of those whose normals differ by less than three degrees
/// or so, lest the pairs of them be too many. Reorders the corners of such a fan.
///
/// unit  normals by triangle.
std::vector<FacetGroup> facet_groups(std::span<std::uint32_t> corners, const std::vector<Vec3d>& unit) {
    constexpr std::size_t many = 256;
    constexpr double cells = 32;  // per unit of length
    const auto cell = [&](std::uint32_t corner) {
        const Vec3d at = unit[corner / 3] * cells;
        return std::array{std::lround(at.x), std::lround(at.y), std::lround(at.z)};
    };
    const bool is_large = corners.size() > many;
    if (is_large)
        std::sort(corners.begin(), corners.end(), [&](std::uint32_t a, std::uint32_t b) {
            return std::pair(cell(a), a) < std::pair(cell(b), b);
        });
    std::vector<FacetGroup> groups;
    for (std::size_t begin = 0, end; begin < corners.size(); begin = end) {
        end = begin + 1;
        while (is_large && end < corners.size() && cell(corners[end]) == cell(corners[begin])) ++end;
        groups.push_back({unit[corners[begin] / 3], corners.subspan(begin, end - begin)});
    }
    return groups;
}

/// One normal per corner of every triangle, [3 * triangle + corner].
///
/// A missing one is the mean of the faces round its position that meet its own face at less than the
/// crease angle, weighted by area and by angle at the corner: by area, so that a flat board with a
/// rounded edge stays flat; by angle, so that the choice of diagonals does not show.
std::vector<Vec3f> corner_normals(const Mesh& mesh, float crease_angle) {
    const std::size_t corner_count = 3 * mesh.triangles.size();
    std::vector<Vec3f> normals(corner_count);
    bool complete = true;
    for (std::size_t c = 0; c < corner_count; ++c) {
        normals[c] = mesh.normals[mesh.triangles[c / 3][c % 3]];
        complete = complete && normals[c].length2() > 0;
    }
    if (complete) return normals;

    std::vector<Vec3d> area(mesh.triangles.size()), unit(mesh.triangles.size());
    std::vector<double> weight(corner_count);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        std::array<Vec3d, 3> p;
        for (int k = 0; k < 3; ++k) p[k] = Vec3d(mesh.positions[mesh.triangles[t][k]]);
        area[t] = (p[1] - p[0]).cross(p[2] - p[0]);
        unit[t] = area[t] / area[t].length();
        for (int k = 0; k < 3; ++k) {
            const Vec3d a = p[(k + 1) % 3] - p[k], b = p[(k + 2) % 3] - p[k];
            weight[3 * t + k] = std::atan2(a.cross(b).length(), a.dot(b));
        }
    }
    const MergedPositions merged = merged_positions(mesh.positions);
    std::vector<std::uint32_t> first(merged.positions.size() + 1, 0), around(corner_count);
    const auto place = [&](std::size_t c) { return merged.index[mesh.triangles[c / 3][c % 3]]; };
    for (std::size_t c = 0; c < corner_count; ++c) ++first[place(c) + 1];
    for (std::size_t i = 1; i < first.size(); ++i) first[i] += first[i - 1];
    std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
    for (std::size_t c = 0; c < corner_count; ++c) around[next[place(c)]++] = static_cast<std::uint32_t>(c);

    const double smooth = std::cos(static_cast<double>(crease_angle));
    const auto missing = [&](std::uint32_t corner) { return normals[corner].length2() == 0; };
    const auto set_normal = [&](std::uint32_t corner, const Vec3d& sum) {
        normals[corner] = Vec3f(sum.length2() > 0 ? sum.normalized() : unit[corner / 3]);
    };
    for (std::size_t p = 0; p + 1 < first.size(); ++p) {
        const std::span<std::uint32_t> corners(around.data() + first[p], first[p + 1] - first[p]);
        if (std::none_of(corners.begin(), corners.end(), missing)) continue;
        std::vector<FacetGroup> groups = facet_groups(corners, unit);
        for (FacetGroup& group : groups)
            for (const std::uint32_t c : group.corners) group.sum += area[c / 3] * weight[c];
        for (const FacetGroup& group : groups) {
            Vec3d sum(0, 0, 0);
            for (const FacetGroup& other : groups)
                if (&other == &group || other.normal.dot(group.normal) > smooth) sum += other.sum;
            for (const std::uint32_t c : group.corners)
                if (missing(c)) set_normal(c, sum);
        }
    }
    return normals;
}

struct VertexKey {
    std::array<std::uint32_t, 7> bits;
    bool operator==(const VertexKey&) const = default;
};

struct VertexKeyHash {
    std::size_t operator()(const VertexKey& key) const {
        std::uint64_t h = 0;
        for (std::uint32_t b : key.bits) {
            h = (h ^ b) * 0x9e3779b97f4a7c15u;
            h ^= h >> 29;
        }
        return h;
    }
};

/// Each vertex once, in the order in which the triangles use them; only materials that are used.
Mesh with_shared_vertices(const Mesh& mesh, const std::vector<Vec3f>& corner_normal) {
    Mesh shared;
    shared.triangles.reserve(mesh.triangles.size());
    std::vector<int> material_index(mesh.material_names.size(), -1);
    std::unordered_map<VertexKey, std::uint32_t, VertexKeyHash> seen;
    seen.reserve(mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        Triangle corners{};
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t vertex = mesh.triangles[t][k];
            int& material = material_index[mesh.vertex_materials[vertex]];
            if (material < 0) {
                material = static_cast<int>(shared.material_names.size());
                shared.material_names.push_back(mesh.material_names[mesh.vertex_materials[vertex]]);
            }
            const Vec3f p = mesh.positions[vertex] + Vec3f(0, 0, 0),
                        n = corner_normal[3 * t + k] + Vec3f(0, 0, 0);
            VertexKey key{};
            for (int axis = 0; axis < 3; ++axis) {
                key.bits[axis] = std::bit_cast<std::uint32_t>(p[axis]);
                key.bits[3 + axis] = std::bit_cast<std::uint32_t>(n[axis]);
            }
            key.bits[6] = static_cast<std::uint32_t>(material);
            const auto [found, is_new] =
                seen.try_emplace(key, static_cast<std::uint32_t>(shared.positions.size()));
            if (is_new) {
                shared.positions.push_back(p);
                shared.normals.push_back(n);
                shared.vertex_materials.push_back(static_cast<std::uint16_t>(material));
            }
            corners[k] = found->second;
        }
        shared.triangles.push_back(corners);
    }
    return shared;
}

}  // namespace

Result<ImportedMesh> read_mesh(const std::filesystem::path& file, const MeshReaderOptions& options) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(file, ignored))
        return Error{file.string(), "there is no such file; wanted a mesh"};
    try {
        Result<Gatherer> gatherer = gathered_faces(file);
        if (!gatherer) return Error{file.string(), "not a mesh that can be read: " + gatherer.error().what};
        if (gatherer->too_large)
            return Error{file.string(),
                         "is too large: wanted coordinates within 1e6 m, fewer than 2^31 "
                         "vertices and 60000 materials"};
        ImportedMesh imported{std::move(gatherer->mesh), gatherer->findings};
        leave_out_bad_triangles(imported.mesh, imported.findings);
        if (imported.mesh.triangles.empty()) {
            const std::string found = imported.findings.summary();
            return Error{file.string(),
                         "has no triangle with an area" + (found.empty() ? "" : " (" + found + ")")};
        }
        orient_triangles(imported.mesh, imported.findings);
        imported.mesh =
            with_shared_vertices(imported.mesh, corner_normals(imported.mesh, options.crease_angle));
        imported.findings.duplicate_vertices =
            imported.mesh.positions.size() - merged_positions(imported.mesh.positions).positions.size();
        return imported;
    } catch (const std::exception& error) {  // assimp's on some damaged files; memory
        return Error{file.string(), std::string("not a mesh that can be read: ") + error.what()};
    }
}

}  // namespace haarfield
