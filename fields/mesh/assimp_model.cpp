#include "fields/mesh/assimp_model.h"

#include "fields/base/srgb.h"
#include "fields/file/mapped_file.h"
#include "fields/mesh/assimp_materials.h"
#include "fields/mesh/obj_leading_zeros.h"

#include <assimp/DefaultIOSystem.h>
#include <assimp/MemoryIOWrapper.h>
#include <assimp/camera.h>
#include <assimp/material.h>
#include <assimp/scene.h>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <iterator>
#include <system_error>

namespace haarfield {
namespace {

/// The folder of a file, and what lies below; a text may stand for the file itself.
///
/// The text outlives the streams over it, as assimp closes them before it lets go of the system.
class FolderIoSystem : public Assimp::DefaultIOSystem {
public:
    FolderIoSystem(const std::filesystem::path& file, std::optional<std::string> text)
        : file_(file.string()), folder_(resolved(file).parent_path()), text_(std::move(text)) {}

    bool Exists(const char* name) const override { return is_below(name) && DefaultIOSystem::Exists(name); }

    Assimp::IOStream* Open(const char* name, const char* mode) override {
        if (mode[0] != 'r' || !is_below(name)) return nullptr;
        if (text_ && file_ == name)
            return new Assimp::MemoryIOStream(reinterpret_cast<const std::uint8_t*>(text_->data()),
                                              text_->size());
        return DefaultIOSystem::Open(name, mode);
    }

private:
    static std::filesystem::path resolved(const std::filesystem::path& path) {
        std::error_code ignored;
        const std::filesystem::path whole = std::filesystem::absolute(path, ignored);
        return std::filesystem::weakly_canonical(whole, ignored);
    }

    bool is_below(const std::filesystem::path& name) const {
        if (name == file_) return true;
        const std::filesystem::path path = resolved(name);
        const auto [end, unused] = std::mismatch(folder_.begin(), folder_.end(), path.begin(), path.end());
        return end == folder_.end();
    }

    const std::string file_;
    const std::filesystem::path folder_;
    const std::optional<std::string> text_;
};

std::unique_ptr<Assimp::IOSystem> file_system_for(const std::filesystem::path& file) {
    if (lower_ending(file) != ".obj") return std::make_unique<FolderIoSystem>(file, std::nullopt);
    std::ifstream stream(file, std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
    std::string mended = with_leading_zeros(text);
    if (!stream || mended == text) return std::make_unique<FolderIoSystem>(file, std::nullopt);
    return std::make_unique<FolderIoSystem>(file, std::move(mended));
}

Vec3f vector_from(const aiVector3D& v) {
    return {v.x, v.y, v.z};
}

/// What assimp has read, put into a Gatherer.
struct SceneGatherer {
    const aiScene& scene;
    const std::filesystem::path& file;
    FaceGatherer& gatherer;
    bool is_gltf;
    std::map<unsigned, std::uint16_t> materials{};  // by their numbers in the scene

    std::uint16_t material_of(const aiMesh& part) {
        const auto [found, is_new] = materials.try_emplace(part.mMaterialIndex, std::uint16_t(0));
        if (!is_new) return found->second;
        std::string name;
        MeshMaterial description;
        if (part.mMaterialIndex < scene.mNumMaterials) {
            const aiMaterial& material = *scene.mMaterials[part.mMaterialIndex];
            aiString text;
            if (material.Get(AI_MATKEY_NAME, text) == aiReturn_SUCCESS) name = text.C_Str();
            if (name == AI_DEFAULT_MATERIAL_NAME) name.clear();
            description = mesh_material(scene, material, file,
                                        [&](std::string_view what) { ++gatherer.unused[std::string(what)]; });
        }
        return found->second = gatherer.new_material(name, description);
    }

    /// Linear: glTF's are, those that others write are as screens show them.
    Rgb colour_from(const aiColor4D& colour) const {
        if (is_gltf) return Rgb(colour.r, colour.g, colour.b);
        return Rgb(srgb_decoded(colour.r), srgb_decoded(colour.g), srgb_decoded(colour.b));
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
        const aiVector3D* uvs = nullptr;
        std::function<Vec2f(const aiVector3D&)> place_in_image;
        if (part.mMaterialIndex < scene.mNumMaterials) {
            const aiMaterial& described = *scene.mMaterials[part.mMaterialIndex];
            const unsigned set = uv_set(described);
            if (part.HasTextureCoords(set)) uvs = part.mTextureCoords[set];
            place_in_image = uv_map(described);
        }
        for (unsigned i = 0; i < part.mNumVertices; ++i) {
            gatherer.add_vertex(
                vector_from(transform * part.mVertices[i]),
                part.HasNormals() ? Vec3d(vector_from(for_normals * part.mNormals[i])) : Vec3d(0, 0, 0),
                material);
            if (uvs) gatherer.set_uv(place_in_image(uvs[i]));
            if (part.HasVertexColors(0)) gatherer.set_colour(colour_from(part.mColors[0][i]));
        }
        for (unsigned i = 0; i < part.mNumFaces; ++i)
            gatherer.add_face({part.mFaces[i].mIndices, part.mFaces[i].mNumIndices}, first);
        if (mirrored)
            for (std::size_t t = first_triangle; t < mesh.triangles.size(); ++t)
                std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
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

/// Whether each media type in a glTF file's text has its two halves: assimp 5.2 looks behind the slash
/// without asking for it.
bool has_whole_media_types(std::string_view text) {
    for (const std::string_view key : {"\"mimeType\"", "\"data:"})
        for (std::size_t at = text.find(key); at != text.npos; at = text.find(key, at + 1)) {
            std::string_view value = text.substr(at + key.size(), 256);
            if (key[1] == 'm') {
                const std::size_t quote = value.find('"');
                if (quote == value.npos) continue;
                value.remove_prefix(quote + 1);
            }
            if (value.substr(0, value.find_first_of("\";,")).find('/') == value.npos) return false;
        }
    return true;
}

/// What assimp takes on trust in a glTF file. errors (with an empty `where`) what is wrong.
Result<Done> check_gltf(const std::filesystem::path& file, bool is_binary) {
    const Result<MappedFile> mapped = mapped_file(file);
    if (!mapped) return Error{"", mapped.error().what};
    if (is_binary && !has_whole_chunks(mapped->bytes)) return Error{"", "a chunk is longer than the file"};
    if (!has_whole_media_types(mapped->bytes))
        return Error{"", "the media type of an image or buffer has no slash; wanted one as image/png"};
    return Done{};
}

/// Calls `act` with each node and where it stands, in the order of the file.
template <class Act>
void for_each_node(const aiScene& scene, const Act& act) {
    std::vector<std::pair<const aiNode*, aiMatrix4x4>> open;
    if (scene.mRootNode) open.emplace_back(scene.mRootNode, scene.mRootNode->mTransformation);
    while (!open.empty()) {
        const auto [node, transform] = open.back();
        open.pop_back();
        act(*node, transform);
        for (unsigned i = node->mNumChildren; i-- > 0;)  // so that they come off in order
            open.emplace_back(node->mChildren[i], transform * node->mChildren[i]->mTransformation);
    }
}

/// The numbers of a node's meshes that are there.
std::vector<unsigned> meshes_of(const aiScene& scene, const aiNode& node) {
    std::vector<unsigned> meshes;
    for (unsigned i = 0; i < node.mNumMeshes; ++i)
        if (node.mMeshes[i] < scene.mNumMeshes) meshes.push_back(node.mMeshes[i]);
    return meshes;
}

AffineMap affine_map(const aiMatrix4x4& m) {
    AffineMap map;
    for (unsigned r = 0; r < 3; ++r) {
        for (unsigned c = 0; c < 3; ++c) map.axes[c][int(r)] = double(m[r][c]);
        map.origin[int(r)] = double(m[r][3]);
    }
    return map;
}

/// The first camera that there is.
std::optional<ModelCamera> camera_of(const aiScene& scene, bool is_gltf) {
    std::optional<ModelCamera> found;
    for_each_node(scene, [&](const aiNode& node, const aiMatrix4x4& transform) {
        for (unsigned i = 0; i < scene.mNumCameras && !found; ++i) {
            const aiCamera& camera = *scene.mCameras[i];
            if (camera.mName != node.mName) continue;
            // Of glTF's cameras assimp says the node's translation a second time.
            const aiVector3D own = is_gltf ? aiVector3D() : camera.mPosition, at = transform * own,
                             ahead = transform * (own + camera.mLookAt) - at;
            ModelCamera made{vector_from(at), vector_from(ahead)};
            if (!is_finite(made.position) || !(made.direction.length() > 0)) continue;
            // assimp multiplies glTF's angle with the aspect; of others it is not sure which angle it is.
            if (is_gltf) {
                const float fov = camera.mHorizontalFOV / (camera.mAspect > 0 ? camera.mAspect : 1);
                if (fov > 0.01f && fov < 3) made.vertical_fov = fov;
            }
            found = made;
        }
    });
    return found;
}

}  // namespace

struct AssimpModel::Content {
    Assimp::Importer importer;
    const aiScene* scene = nullptr;
    std::filesystem::path file;
    bool is_gltf = false;
    std::vector<std::vector<unsigned>> meshes;  ///< By part.
};

bool AssimpModel::reads(const std::string& ending) {
    return Assimp::Importer().IsExtensionSupported(ending);
}

Result<AssimpModel> AssimpModel::open(const std::filesystem::path& file) {
    const std::string ending = lower_ending(file);
    const bool is_gltf = ending == ".glb" || ending == ".gltf";
    if (is_gltf)
        if (const Result<Done> good = check_gltf(file, ending == ".glb"); !good) return good.error();
    const auto content = std::make_shared<Content>();
    content->file = file;
    content->is_gltf = is_gltf;
    if (!reads(ending))
        return Error{"",
                     (ending.empty() ? "has no ending" : "has the ending " + ending) +
                         ", which nothing here reads; wanted .obj, .ply, .gltf, .glb, .stl, .off, .inc, .pov "
                         "or another of assimp's formats"};
    content->importer.SetIOHandler(file_system_for(file).release());  // the importer's own from here on
    // no post-processing: it would take indices and coordinates on trust
    content->scene = content->importer.ReadFile(file.string(), 0);
    if (!content->scene) return Error{"", content->importer.GetErrorString()};

    AssimpModel model;
    const aiScene& scene = *content->scene;
    std::map<std::vector<unsigned>, std::size_t> known;
    std::set<std::string> taken;
    for_each_node(scene, [&](const aiNode& node, const aiMatrix4x4& transform) {
        const std::vector<unsigned> meshes = meshes_of(scene, node);
        if (meshes.empty()) return;
        const auto [part, is_new] = known.emplace(meshes, content->meshes.size());
        if (is_new) {
            content->meshes.push_back(meshes);
            const std::string of_mesh = scene.mMeshes[meshes[0]]->mName.C_Str();
            model.parts_.names.push_back(
                unique_name(of_mesh.empty() ? node.mName.C_Str() : of_mesh, taken, " (", ")"));
        }
        model.parts_.nodes.push_back({node.mName.C_Str(), part->second, affine_map(transform)});
    });
    model.parts_.camera = camera_of(scene, content->is_gltf);
    model.content_ = content;
    return model;
}

void AssimpModel::gather(FaceGatherer& to) const {
    SceneGatherer gatherer{*content_->scene, content_->file, to, content_->is_gltf};
    for_each_node(*content_->scene, [&](const aiNode& node, const aiMatrix4x4& transform) {
        if (to.too_large) return;
        for (const unsigned mesh : meshes_of(*content_->scene, node))
            gatherer.add(*content_->scene->mMeshes[mesh], transform);
    });
}

void AssimpModel::gather_part(std::size_t part, FaceGatherer& to) const {
    SceneGatherer gatherer{*content_->scene, content_->file, to, content_->is_gltf};
    for (const unsigned mesh : content_->meshes[part])
        gatherer.add(*content_->scene->mMeshes[mesh], aiMatrix4x4());
}

}  // namespace haarfield
