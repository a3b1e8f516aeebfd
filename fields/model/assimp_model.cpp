#include "fields/model/assimp_model.h"

#include "fields/model/assimp_content.h"

#include <assimp/types.h>
#include <algorithm>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <span>
#include <system_error>

namespace haarfield {
namespace {

bool is_file(const std::filesystem::path& path) {
    std::error_code ignored;
    return std::filesystem::is_regular_file(path, ignored);
}

/// Returns the path of a file that a mesh's file names, if it is in that file's folder or below; otherwise a
/// file of the same name in that folder.
std::filesystem::path beside(const std::filesystem::path& file, std::string name) {
    std::replace(name.begin(), name.end(), '\\', '/');
    const std::filesystem::path folder = file.parent_path(), named(name);
    const std::filesystem::path plain = named.lexically_normal();
    const bool is_below = named.is_relative() && !plain.empty() && *plain.begin() != "..";
    if (is_below && is_file(folder / plain)) return folder / plain;
    if (named.has_filename() && is_file(folder / named.filename())) return folder / named.filename();
    return {};
}

aiMatrix4x4 matrix_from(const std::array<float, 16>& rows) {
    aiMatrix4x4 matrix;
    for (unsigned r = 0; r < 4; ++r)
        for (unsigned c = 0; c < 4; ++c) matrix[r][c] = rows[4 * r + c];
    return matrix;
}

AffineMap affine_map(const std::array<float, 16>& rows) {
    AffineMap map;
    for (std::size_t r = 0; r < 3; ++r) {
        for (std::size_t c = 0; c < 3; ++c) map.axes[c][int(r)] = double(rows[4 * r + c]);
        map.origin[int(r)] = double(rows[4 * r + 3]);
    }
    return map;
}

Vec3f turned(const auto& by, const Vec3f& v) {
    const aiVector3D to = by * aiVector3D(v.x, v.y, v.z);
    return {to.x, to.y, to.z};
}

bool is_mirrored(const aiMatrix4x4& transform) {
    return aiMatrix3x3(transform).Determinant() < 0;
}

/// Appends vertices and faces, with consecutive numbers.
void list_mesh(const ContentMesh& mesh, const aiMatrix4x4& transform, ListedMesh& to) {
    const auto first = static_cast<std::uint32_t>(to.positions.size());
    for (const Vec3f& position : mesh.positions) {
        to.numbers.push_back(static_cast<std::int32_t>(to.positions.size()));
        to.positions.push_back(turned(transform, position));
    }
    std::span<const std::uint32_t> corners = mesh.corners;
    const std::size_t faces = mesh.face_corners.empty() ? corners.size() / 3 : mesh.face_corners.size();
    for (std::size_t f = 0; f < faces; ++f) {
        const std::size_t count = mesh.face_corners.empty() ? 3 : mesh.face_corners[f];
        const std::span<const std::uint32_t> face = corners.first(count);
        corners = corners.subspan(count);
        if (std::ranges::any_of(face, [&](std::uint32_t c) { return c >= mesh.positions.size(); })) continue;
        const std::size_t begin = to.corners.size();
        for (const std::uint32_t corner : face) to.corners.push_back(first + corner);
        if (is_mirrored(transform) && count > 0)
            std::reverse(to.corners.begin() + static_cast<std::ptrdiff_t>(begin) + 1, to.corners.end());
        to.face_corners.push_back(static_cast<std::uint32_t>(count));
    }
}

/// Returns the vertices and faces that a part of an OBJ file uses.
ListedMesh listed_part(const ContentListing& file, std::vector<std::uint32_t> faces) {
    std::ranges::sort(faces);
    std::vector<std::uint32_t> first{0};
    for (const std::uint32_t count : file.face_corners) first.push_back(first.back() + count);
    const auto corners_of = [&](std::uint32_t face) {
        return std::span(file.corners).subspan(first[face], file.face_corners[face]);
    };
    std::vector<bool> is_used(file.positions.size());
    for (const std::uint32_t face : faces)
        for (const std::uint32_t corner : corners_of(face)) is_used[corner] = true;
    ListedMesh part;
    std::vector<std::uint32_t> index(file.positions.size());
    for (std::uint32_t v = 0; v < file.positions.size(); ++v) {
        index[v] = static_cast<std::uint32_t>(part.positions.size());
        if (!is_used[v]) continue;
        part.positions.push_back(file.positions[v]);
        part.numbers.push_back(static_cast<std::int32_t>(v));
    }
    for (const std::uint32_t face : faces) {
        for (const std::uint32_t corner : corners_of(face)) part.corners.push_back(index[corner]);
        part.face_corners.push_back(file.face_corners[face]);
    }
    return part;
}

/// Adds a model's content to a FaceGatherer.
struct ContentGatherer {
    const ModelContent& content;
    FaceGatherer& gatherer;
    std::map<std::uint32_t, std::uint16_t> materials{};  // by their indices in the content

    std::uint16_t material_of(const ContentMesh& part) {
        const auto [found, is_new] = materials.try_emplace(part.material, std::uint16_t(0));
        if (!is_new) return found->second;
        if (part.material == ContentMesh::no_material) return found->second = gatherer.new_material("", {});
        const ContentMaterial& material = content.materials[part.material];
        for (const std::string& what : material.unused) ++gatherer.unused[what];
        return found->second = gatherer.new_material(material.name, material.description);
    }

    void add(const ContentMesh& part, const aiMatrix4x4& transform) {
        const std::int32_t first_number = gatherer.listed;
        gatherer.pass_vertices(part.positions.size());
        if (part.corners.empty() || part.positions.empty() || !gatherer.has_room_for(part.positions.size()))
            return;
        Mesh& mesh = gatherer.mesh;
        const std::uint32_t first = static_cast<std::uint32_t>(mesh.positions.size());
        const std::size_t first_triangle = mesh.triangles.size();
        const std::uint16_t material = material_of(part);
        aiMatrix3x3 for_normals(transform);
        for_normals.Inverse().Transpose();
        for (std::size_t i = 0; i < part.positions.size(); ++i) {
            gatherer.add_vertex(
                turned(transform, part.positions[i]),
                part.normals.empty() ? Vec3d(0, 0, 0) : Vec3d(turned(for_normals, part.normals[i])), material,
                content.listing ? part.numbers[i] : first_number + static_cast<std::int32_t>(i));
            if (!part.uvs.empty()) gatherer.set_uv(part.uvs[i]);
            if (!part.colours.empty()) gatherer.set_colour(part.colours[i]);
        }
        std::span<const std::uint32_t> corners = part.corners;
        const std::size_t faces = part.face_corners.empty() ? corners.size() / 3 : part.face_corners.size();
        for (std::size_t f = 0; f < faces; ++f) {
            const std::size_t count = part.face_corners.empty() ? 3 : part.face_corners[f];
            gatherer.add_face(corners.first(count), first);
            corners = corners.subspan(count);
        }
        if (is_mirrored(transform))
            for (std::size_t t = first_triangle; t < mesh.triangles.size(); ++t)
                std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
    }
};

}  // namespace

struct AssimpModel::Content {
    ModelContent model;
    std::vector<std::vector<std::uint32_t>> meshes;  ///< By part.
};

Result<AssimpModel> AssimpModel::from(std::string_view bytes, const std::filesystem::path& file,
                                      ModelFormat format) {
    HF_TRY(ModelContent read, guarded_content(bytes, file, format));
    const auto content = std::make_shared<Content>();
    content->model = std::move(read);
    for (ContentMaterial& material : content->model.materials)
        for (MeshImage* image : {&material.description.image, &material.description.surface_map,
                                 &material.description.opacity_map})
            if (!image->name.empty() && !image->bytes) image->file = beside(file, image->name);

    AssimpModel model;
    std::map<std::vector<std::uint32_t>, std::size_t> known;
    std::set<std::string> taken;
    for (const ContentNode& node : content->model.nodes) {
        const auto [part, is_new] = known.emplace(node.meshes, content->meshes.size());
        if (is_new) {
            content->meshes.push_back(node.meshes);
            const std::string& of_mesh = content->model.meshes[node.meshes[0]].name;
            model.parts_.names.push_back(
                unique_name(of_mesh.empty() ? node.name : of_mesh, taken, " (", ")"));
        }
        model.parts_.nodes.push_back({node.name, part->second, affine_map(node.transform)});
    }
    model.parts_.camera = content->model.camera;
    model.parts_.lights = content->model.lights;
    model.content_ = content;
    return model;
}

void AssimpModel::gather(FaceGatherer& to) const {
    ContentGatherer gatherer{content_->model, to};
    for (const ContentNode& node : content_->model.nodes) {
        if (to.too_large) return;
        const aiMatrix4x4 transform = matrix_from(node.transform);
        for (const std::uint32_t mesh : node.meshes) gatherer.add(content_->model.meshes[mesh], transform);
    }
}

void AssimpModel::gather_part(std::size_t part, FaceGatherer& to) const {
    ContentGatherer gatherer{content_->model, to};
    for (const std::uint32_t mesh : content_->meshes[part])
        gatherer.add(content_->model.meshes[mesh], aiMatrix4x4());
}

std::map<std::string, std::set<std::string>> AssimpModel::unused() const {
    std::map<std::string, std::set<std::string>> unused;
    for (const ContentMesh& mesh : content_->model.meshes) {
        if (mesh.material == ContentMesh::no_material || mesh.corners.empty()) continue;
        const ContentMaterial& material = content_->model.materials[mesh.material];
        for (const std::string& what : material.unused) unused[what].insert(material.name);
    }
    return unused;
}

ListedMesh AssimpModel::listed(std::optional<std::size_t> part) const {
    const ModelContent& model = content_->model;
    ListedMesh made;
    if (model.listing && !part) {  // its nodes have no transformations
        made = {model.listing->positions, {}, model.listing->corners, model.listing->face_corners};
        made.numbers.resize(made.positions.size());
        std::iota(made.numbers.begin(), made.numbers.end(), 0);
        return made;
    }
    if (model.listing) {
        std::vector<std::uint32_t> faces;
        for (const std::uint32_t mesh : content_->meshes[*part])
            faces.insert(faces.end(), model.meshes[mesh].faces.begin(), model.meshes[mesh].faces.end());
        return listed_part(*model.listing, std::move(faces));
    }
    if (part) {
        for (const std::uint32_t mesh : content_->meshes[*part])
            list_mesh(model.meshes[mesh], aiMatrix4x4(), made);
        return made;
    }
    for (const ContentNode& node : model.nodes)
        for (const std::uint32_t mesh : node.meshes)
            list_mesh(model.meshes[mesh], matrix_from(node.transform), made);
    return made;
}

}  // namespace haarfield
