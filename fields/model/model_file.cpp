#include "fields/model/model_file.h"

#include "fields/base/exception_message.h"
#include "fields/base/names.h"
#include "fields/file/input_file.h"
#include "fields/file/mapped_file.h"

#include <fmt/format.h>
#include <algorithm>
#include <cassert>
#include <numeric>

namespace haarfield {

namespace {

void gather(const PolygonFile& file, FaceGatherer& to) {
    if (!to.has_room_for(file.positions.size())) return;
    MeshMaterial description;
    if (!file.colours.empty()) {
        description.model = MeshMaterial::Model::by_colour;
        description.diffuse = Rgb(1.0f);
    }
    const std::uint16_t material = to.new_material("", description);
    for (std::size_t v = 0; v < file.positions.size(); ++v) {
        to.add_vertex(file.positions[v], file.normals.empty() ? Vec3d(0, 0, 0) : Vec3d(file.normals[v]),
                      material, static_cast<std::int32_t>(v));
        if (!file.colours.empty()) to.set_colour(file.colours[v]);
        if (!file.uvs.empty()) to.set_uv(file.uvs[v]);
    }
    std::span<const std::uint32_t> corners = file.corners;
    for (const std::uint32_t count : file.face_corners) {
        to.add_face(corners.first(count), 0);
        corners = corners.subspan(count);
    }
}

/// Adds one vertex for each material of the triangles at a vertex.
void gather(const MeshInMemory& mesh, FaceGatherer& to) {
    if (!to.has_room_for(3 * mesh.triangles.size())) return;
    MeshMaterial description;
    if (!mesh.colours.empty()) {
        description.model = MeshMaterial::Model::by_colour;
        description.diffuse = Rgb(1.0f);
    }
    std::vector<std::uint16_t> material;
    for (const std::string& name : mesh.material_names)
        material.push_back(to.new_material(name, description));
    std::map<std::pair<std::uint32_t, std::uint16_t>, std::uint32_t> added;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const std::uint16_t own = material[mesh.triangle_materials.empty() ? 0 : mesh.triangle_materials[t]];
        std::array<std::uint32_t, 3> corners{};
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t v = mesh.triangles[t][k];
            const auto [known, is_new] =
                added.try_emplace({v, own}, static_cast<std::uint32_t>(to.mesh.positions.size()));
            corners[k] = known->second;
            if (!is_new) continue;
            to.add_vertex(mesh.positions[v], mesh.normals.empty() ? Vec3d(0, 0, 0) : Vec3d(mesh.normals[v]),
                          own, static_cast<std::int32_t>(v));
            if (!mesh.uvs.empty()) to.set_uv(mesh.uvs[v]);
            if (!mesh.colours.empty()) to.set_colour(mesh.colours[v]);
        }
        to.add_face(corners, 0);
    }
}

/// The materials of a mesh2's faces, determined once per texture.
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
        // The blended textures are vertex colours, not materials.
        has_colours_ = std::any_of(mesh_.faces.begin(), mesh_.faces.end(), is_blended);
        is_plain_ = mesh_.textures.size() == 1;
        of_texture_.assign(mesh_.textures.size(), unknown);
    }

    std::uint16_t of(const Mesh2Face& face, FaceGatherer& gatherer) {
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

/// Adds a placed mesh, with a separate vertex for every corner.
void gather(const Mesh2File& file, const PlacedMesh2& placed, FaceGatherer& to) {
    const Mesh2& part = file.meshes[placed.mesh];
    const std::int32_t first_number = to.listed;
    to.pass_vertices(part.positions.size());
    if (!to.has_room_for(3 * part.faces.size())) return;
    Mesh2Materials named(file, placed);
    const bool mirrored = placed.transform.is_mirrored();
    for (const Mesh2Face& face : part.faces) {
        const std::uint16_t material = named.of(face, to);
        if (!to.has_room_for(0)) return;
        const auto first = static_cast<std::uint32_t>(to.mesh.positions.size());
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3d position(part.positions[face.positions[k]]);
            Vec3d normal(0, 0, 0);
            if (face.normals[k] != Mesh2Face::none)
                normal = placed.transform.normal(Vec3d(part.normals[face.normals[k]]));
            to.add_vertex(Vec3f(placed.transform.point(position)), normal, material,
                          first_number + static_cast<std::int32_t>(face.positions[k]));
            if (face.uvs[k] != Mesh2Face::none)
                to.set_uv({part.uvs[face.uvs[k]][0], part.uvs[face.uvs[k]][1]});
        }
        constexpr std::array<std::uint32_t, 3> as_it_is{0, 1, 2}, turned{0, 2, 1};
        to.add_face(mirrored ? turned : as_it_is, first);
    }
}

/// Returns a list of vertices, numbered from 0.
ListedMesh listed_vertices(std::vector<Vec3f> positions) {
    ListedMesh listed{std::move(positions), {}, {}, {}};
    listed.numbers.resize(listed.positions.size());
    std::iota(listed.numbers.begin(), listed.numbers.end(), 0);
    return listed;
}

/// Lists several meshes at their placements.
ListedMesh listed_meshes(const Mesh2File& file, std::span<const PlacedMesh2> placed) {
    std::vector<Vec3f> positions;
    for (const PlacedMesh2& mesh : placed)
        for (const Vec3f& position : file.meshes[mesh.mesh].positions)
            positions.push_back(Vec3f(mesh.transform.point(Vec3d(position))));
    ListedMesh made = listed_vertices(std::move(positions));
    std::uint32_t first = 0;
    for (const PlacedMesh2& mesh : placed) {
        const bool mirrored = mesh.transform.is_mirrored();
        for (const Mesh2Face& face : file.meshes[mesh.mesh].faces) {
            const auto& [a, b, c] = face.positions;
            made.corners.insert(made.corners.end(),
                                {first + a, first + (mirrored ? c : b), first + (mirrored ? b : c)});
            made.face_corners.push_back(3);
        }
        first += static_cast<std::uint32_t>(file.meshes[mesh.mesh].positions.size());
    }
    return made;
}

/// Returns the parts of a file: each combination of a mesh and a material.
ModelParts parts_of(const Mesh2File& file, std::vector<std::size_t>& placed_of_part) {
    ModelParts parts;
    std::map<std::pair<std::size_t, std::string>, std::size_t> known;
    std::set<std::string> taken;
    for (std::size_t i = 0; i < file.placed.size(); ++i) {
        const PlacedMesh2& placed = file.placed[i];
        const std::string& name = file.meshes[placed.mesh].name;
        const auto [part, is_new] =
            known.emplace(std::pair(placed.mesh, placed.material), parts.names.size());
        if (is_new) {
            parts.names.push_back(unique_name(name, taken, " (", ")"));
            placed_of_part.push_back(i);
        }
        parts.nodes.push_back({name, part->second, placed.transform});
    }
    parts.lights = file.lights;
    parts.unread_lights = file.unread_lights;
    return parts;
}

}  // namespace

Result<ModelFile> ModelFile::open(const std::filesystem::path& file) {
    HF_TRY_DONE(check_input_file(file, "a mesh"));
    const auto unreadable = [&](const std::string& what) {
        return Error{file.string(), "not a mesh that can be read: " + what};
    };
    ModelFile model;
    model.file_ = file;
    try {
        HF_TRY(const MappedFile mapped, mapped_file(file, MappedPages::as_read));
        const std::optional<ModelFormat> format = model_format(mapped.bytes, lower_ending(file));
        if (!format) return unreadable(fmt::format("found no supported format; expected {}", model_formats));
        HF_TRY_DONE(load_pages(mapped, file.string()));
        if (*format == ModelFormat::mesh2) {
            Result<Mesh2File> meshes = read_mesh2(mapped.bytes);
            if (!meshes) return unreadable(meshes.error().what);
            model.parts_ = parts_of(*meshes, model.placed_of_part_);
            model.content_ = std::move(*meshes);
            return model;
        }
        if (*format != ModelFormat::ply && *format != ModelFormat::off) {
            Result<AssimpModel> read = AssimpModel::from(mapped.bytes, file, *format);
            if (!read) return unreadable(read.error().what);
            model.parts_ = read->parts();
            model.content_ = std::move(*read);
            return model;
        }
        Result<PolygonFile> polygons =
            *format == ModelFormat::ply ? read_ply(mapped.bytes) : read_off(mapped.bytes);
        if (!polygons) return unreadable(polygons.error().what);
        model.parts_.names = {file.stem().string()};
        model.parts_.nodes = {{model.parts_.names[0], 0}};
        model.content_ = std::move(*polygons);
        return model;
    } catch (const std::exception& error) {  // out of memory
        return unreadable(exception_message(error));
    }
}

ModelFile ModelFile::of(MeshInMemory mesh, const std::string& name) {
    assert(mesh.normals.empty() || mesh.normals.size() == mesh.positions.size());
    assert(mesh.uvs.empty() || mesh.uvs.size() == mesh.positions.size());
    assert(mesh.colours.empty() || mesh.colours.size() == mesh.positions.size());
    assert(mesh.triangle_materials.empty() || mesh.triangle_materials.size() == mesh.triangles.size());
    ModelFile model;
    model.file_ = name;
    model.parts_.names = {name};
    model.parts_.nodes = {{name, 0}};
    model.content_ = std::move(mesh);
    return model;
}

bool ModelFile::is_left_handed() const {
    const auto* meshes = std::get_if<Mesh2File>(&content_);
    return meshes && meshes->left_handed;
}

Result<FaceGatherer> ModelFile::faces(std::optional<std::size_t> part) const {
    FaceGatherer gathered;
    try {
        if (const auto* by_assimp = std::get_if<AssimpModel>(&content_)) {
            if (part)
                by_assimp->gather_part(*part, gathered);
            else
                by_assimp->gather(gathered);
        } else if (const auto* polygons = std::get_if<PolygonFile>(&content_)) {
            gather(*polygons, gathered);
        } else if (const auto* mesh = std::get_if<MeshInMemory>(&content_)) {
            gather(*mesh, gathered);
        } else {
            const auto& meshes = std::get<Mesh2File>(content_);
            if (part) {
                PlacedMesh2 own = meshes.placed[placed_of_part_[*part]];
                own.transform = {};
                gather(meshes, own, gathered);
            } else {
                for (const PlacedMesh2& placed : meshes.placed) gather(meshes, placed, gathered);
            }
        }
    } catch (const std::exception& error) {  // out of memory
        return Error{file_.string(), "not a mesh that can be read: " + exception_message(error)};
    }
    if (gathered.too_large)
        return Error{file_.string(),
                     "is too large; expected coordinates within 1e6 m, fewer than 2^31 "
                     "vertices and 60000 materials"};
    gathered.findings.non_finite_vertices = gathered.non_finite.size();
    return gathered;
}

UnusedProperties ModelFile::unused() const {
    const auto* by_assimp = std::get_if<AssimpModel>(&content_);
    return by_assimp ? by_assimp->unused() : UnusedProperties();
}

Result<ListedMesh> ModelFile::listed(std::optional<std::size_t> part) const {
    try {
        if (const auto* by_assimp = std::get_if<AssimpModel>(&content_)) return by_assimp->listed(part);
        if (const auto* polygons = std::get_if<PolygonFile>(&content_)) {
            ListedMesh made = listed_vertices(polygons->positions);
            made.corners = polygons->corners;
            made.face_corners = polygons->face_corners;
            return made;
        }
        if (const auto* mesh = std::get_if<MeshInMemory>(&content_)) {
            ListedMesh made = listed_vertices(mesh->positions);
            for (const auto& triangle : mesh->triangles)
                made.corners.insert(made.corners.end(), triangle.begin(), triangle.end());
            made.face_corners.assign(mesh->triangles.size(), 3);
            return made;
        }
        const auto& meshes = std::get<Mesh2File>(content_);
        if (!part) return listed_meshes(meshes, meshes.placed);
        PlacedMesh2 own = meshes.placed[placed_of_part_[*part]];
        own.transform = {};
        return listed_meshes(meshes, {&own, 1});
    } catch (const std::exception& error) {  // out of memory
        return Error{file_.string(), "not a mesh that can be read: " + exception_message(error)};
    }
}

}  // namespace haarfield
