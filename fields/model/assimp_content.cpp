#include "fields/model/assimp_content.h"

#include "fields/base/exception_message.h"
#include "fields/base/large_stack.h"
#include "fields/base/srgb.h"
#include "fields/file/input_file.h"
#include "fields/file/mapped_file.h"
#include "fields/model/assimp_materials.h"
#include "fields/model/gltf_nodes.h"
#include "fields/model/mtl_statements.h"
#include "fields/model/obj_leading_zeros.h"
#include "fields/model/obj_listing.h"

#include <assimp/BaseImporter.h>
#include <assimp/DefaultIOSystem.h>
#include <assimp/MemoryIOWrapper.h>
#include <assimp/camera.h>
#include <assimp/light.h>
#include <assimp/material.h>
#include <assimp/scene.h>
#include <assimp/version.h>
#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstring>
#include <system_error>

namespace haarfield {
namespace {

/// assimp's names for a format: the extension of its files, and its importer.
struct AssimpFormat {
    const char* ending;
    const char* importer;  ///< The beginning of its name.
};

AssimpFormat assimp_format(ModelFormat format) {
    switch (format) {
        case ModelFormat::obj: return {".obj", "Wavefront Object Importer"};
        case ModelFormat::stl: return {".stl", "Stereolithography (STL) Importer"};
        case ModelFormat::gltf: return {".gltf", "glTF2 Importer"};
        case ModelFormat::glb: return {".glb", "glTF2 Importer"};
        case ModelFormat::ply:
        case ModelFormat::off:
        case ModelFormat::mesh2: break;
    }
    return {"", ""};  // unreachable: these formats have their own readers
}

/// Removes all importers but one.
void keep_importer(Assimp::Importer& importer, const char* wanted) {
    for (std::size_t i = importer.GetImporterCount(); i-- > 0;) {
        Assimp::BaseImporter* const known = importer.GetImporter(i);
        if (std::strcmp(importer.GetImporterInfo(i)->mName, wanted) == 0) continue;
        importer.UnregisterLoader(known);
        delete known;
    }
}

/// Presents a text as a file, and gives access to the folder of that file and everything below. Names of
/// files are never URLs. Names with `..` are refused.
///
/// The text outlives the streams over it, because assimp closes them before it releases the system. All other
/// files that assimp opens for an OBJ file are MTL files. Their statements before the first material are
/// removed.
class FolderIoSystem : public Assimp::DefaultIOSystem {
public:
    FolderIoSystem(std::filesystem::path file, std::string_view text, ModelFormat format)
        : file_(std::move(file)), folder_(resolved(file_.parent_path())), text_(text), format_(format) {}

    bool Exists(const char* name) const override {
        return file_ == name || (is_below(name) && DefaultIOSystem::Exists(name));
    }

    Assimp::IOStream* Open(const char* name, const char* mode) override {
        if (mode[0] != 'r') return nullptr;
        if (file_ == name)
            return new Assimp::MemoryIOStream(reinterpret_cast<const std::uint8_t*>(text_.data()),
                                              text_.size());
        if (!is_below(name)) return nullptr;
        return format_ == ModelFormat::obj ? mtl_stream(name) : DefaultIOSystem::Open(name, mode);
    }

private:
    static std::filesystem::path resolved(const std::filesystem::path& path) {
        std::error_code ignored;
        return std::filesystem::weakly_canonical(path, ignored);
    }

    static Assimp::IOStream* mtl_stream(const char* name) {
        constexpr std::uint64_t largest = std::uint64_t{64} << 20;
        Result<std::string> text = read_whole_file(name, largest);
        if (!text) return nullptr;
        std::string mended = without_leading_statements(*std::move(text));
        mended.append(8, '\n');  // assimp 5.2 rejects an OBJ file if a text is shorter
        auto* const bytes = new std::uint8_t[mended.size()];
        std::memcpy(bytes, mended.data(), mended.size());
        return new Assimp::MemoryIOStream(bytes, mended.size(), /*own=*/true);
    }

    bool is_below(const std::filesystem::path& name) const {
        std::error_code ignored;
        if (!std::filesystem::is_regular_file(name, ignored)) return false;
        // assimp builds names from the file's own folder and the name in the file.
        const std::filesystem::path& own = file_.parent_path();
        const auto [own_end, said] = std::mismatch(own.begin(), own.end(), name.begin(), name.end());
        if (own_end == own.end() && std::find(said, name.end(), "..") != name.end()) return false;
        const std::filesystem::path path = resolved(name);
        const auto [end, unused] = std::mismatch(folder_.begin(), folder_.end(), path.begin(), path.end());
        return end == folder_.end();
    }

    const std::filesystem::path file_, folder_;
    const std::string_view text_;
    const ModelFormat format_;
};

Vec3f vector_from(const aiVector3D& v) {
    return {v.x, v.y, v.z};
}

/// Tests whether the chunks of a GLB file are as long as their headers state. assimp allocates memory for
/// them without a check.
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

/// Returns the JSON of a glTF or GLB file.
std::string_view gltf_json(std::string_view bytes, bool is_binary) {
    constexpr std::size_t file_head = 12, chunk_head = 8;
    if (!is_binary) return bytes;
    if (bytes.size() < file_head + chunk_head) return {};
    std::uint32_t length = 0;
    std::memcpy(&length, bytes.data() + file_head, sizeof length);
    return bytes.substr(file_head + chunk_head, length);
}

/// Tests whether each media type in the text of a glTF file contains a slash. assimp 5.2 reads behind the
/// slash without testing that there is one.
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

/// Checks for defects in a glTF file that assimp does not check.
///
/// errors  (with an empty `where`) the first defect.
Result<GltfDepth> check_gltf(std::string_view bytes, bool is_binary) {
    if (is_binary && !has_whole_chunks(bytes)) return Error{"", "a chunk is longer than the file"};
    if (!has_whole_media_types(bytes))
        return Error{"", "the media type of an image or buffer has no slash; expected one such as image/png"};
    return check_gltf_nodes(gltf_json(bytes, is_binary));
}

/// Calls `act` with each node and its transformation, in the order of the file.
template <class Act>
void for_each_node(const aiScene& scene, const Act& act) {
    std::vector<std::pair<const aiNode*, aiMatrix4x4>> open;
    if (scene.mRootNode) open.emplace_back(scene.mRootNode, scene.mRootNode->mTransformation);
    while (!open.empty()) {
        const auto [node, transform] = open.back();
        open.pop_back();
        act(*node, transform);
        for (unsigned i = node->mNumChildren; i-- > 0;)  // reversed, because they are taken from the end
            open.emplace_back(node->mChildren[i], transform * node->mChildren[i]->mTransformation);
    }
}

/// Returns the valid mesh indices of a node.
std::vector<std::uint32_t> meshes_of(const aiScene& scene, const aiNode& node) {
    std::vector<std::uint32_t> meshes;
    for (unsigned i = 0; i < node.mNumMeshes; ++i)
        if (node.mMeshes[i] < scene.mNumMeshes) meshes.push_back(node.mMeshes[i]);
    return meshes;
}

/// Returns the angle that a glTF file declares. assimp converts it to a horizontal one: up to version 5.2 by
/// multiplication by the aspect ratio, later by tangents (as measured with 5.2.5 and 5.4.3). [rad]
float vertical_fov(const aiCamera& camera) {
    const float aspect = camera.mAspect > 0 ? camera.mAspect : 1;
    if (aiGetVersionMajor() * 100 + aiGetVersionMinor() <= 502) return camera.mHorizontalFOV / aspect;
    return 2 * std::atan(std::tan(camera.mHorizontalFOV / 2) / aspect);
}

/// Returns the first valid camera.
std::optional<ModelCamera> camera_of(const aiScene& scene, bool is_gltf) {
    std::optional<ModelCamera> found;
    for_each_node(scene, [&](const aiNode& node, const aiMatrix4x4& transform) {
        for (unsigned i = 0; i < scene.mNumCameras && !found; ++i) {
            const aiCamera& camera = *scene.mCameras[i];
            if (camera.mName != node.mName) continue;
            // For glTF cameras, assimp repeats the node's translation in the position.
            const aiVector3D own = is_gltf ? aiVector3D() : camera.mPosition, at = transform * own,
                             ahead = transform * (own + camera.mLookAt) - at;
            ModelCamera made{vector_from(at), vector_from(ahead)};
            if (!is_finite(made.position) || !(made.direction.length() > 0)) continue;
            // For formats other than glTF, assimp's definition of the angle varies.
            if (const float fov = is_gltf ? vertical_fov(camera) : 0; fov > 0.01f && fov < 3)
                made.vertical_fov = fov;
            found = made;
        }
    });
    return found;
}

constexpr float lumens_a_watt = 683;  ///< glTF's units are photometric.

/// Returns the lights of glTF's KHR_lights_punctual. For other formats, assimp's units vary.
std::vector<ModelLight> lights_of(const aiScene& scene) {
    std::vector<ModelLight> lights;
    for_each_node(scene, [&](const aiNode& node, const aiMatrix4x4& transform) {
        for (unsigned i = 0; i < scene.mNumLights; ++i) {
            const aiLight& light = *scene.mLights[i];
            if (light.mName != node.mName) continue;
            const aiVector3D at = transform * aiVector3D(), ahead = transform * aiVector3D(0, 0, -1) - at;
            ModelLight made;
            made.name = node.mName.C_Str();
            made.is_physical = true;
            made.colour =
                Rgb(light.mColorDiffuse.r, light.mColorDiffuse.g, light.mColorDiffuse.b) / lumens_a_watt;
            made.position = vector_from(at);
            made.target = vector_from(at + ahead);
            if (light.mType == aiLightSource_DIRECTIONAL)
                made.kind = ModelLight::Kind::parallel;
            else if (light.mType == aiLightSource_SPOT)
                made.kind = ModelLight::Kind::spot;
            else if (light.mType != aiLightSource_POINT)
                continue;
            if (made.kind == ModelLight::Kind::spot) {
                made.radius = light.mAngleInnerCone;
                made.falloff = light.mAngleOuterCone;
            }
            if (is_light(made)) lights.push_back(std::move(made));
        }
    });
    return lights;
}

std::array<float, 16> rows_of(const aiMatrix4x4& m) {
    std::array<float, 16> rows;
    for (unsigned r = 0; r < 4; ++r)
        for (unsigned c = 0; c < 4; ++c) rows[4 * r + c] = m[r][c];
    return rows;
}

ContentMaterial content_of(const aiScene& scene, const aiMaterial& material) {
    ContentMaterial made;
    aiString text;
    if (material.Get(AI_MATKEY_NAME, text) == aiReturn_SUCCESS) made.name = text.C_Str();
    if (made.name == AI_DEFAULT_MATERIAL_NAME) made.name.clear();
    made.description =
        mesh_material(scene, material, [&](std::string_view what) { made.unused.emplace_back(what); });
    return made;
}

ContentMesh content_of(const aiScene& scene, const aiMesh& part, bool is_gltf) {
    ContentMesh made;
    made.name = part.mName.C_Str();
    if (!part.HasFaces() || !part.HasPositions()) return made;
    const aiMaterial* const material =
        part.mMaterialIndex < scene.mNumMaterials ? scene.mMaterials[part.mMaterialIndex] : nullptr;
    if (material) made.material = part.mMaterialIndex;
    const unsigned set = material ? uv_set(*material) : 0;
    const std::size_t vertices = part.mNumVertices;
    made.positions.reserve(vertices);
    for (std::size_t i = 0; i < vertices; ++i) made.positions.push_back(vector_from(part.mVertices[i]));
    if (part.HasNormals())
        for (std::size_t i = 0; i < vertices; ++i) made.normals.push_back(vector_from(part.mNormals[i]));
    if (material && part.HasTextureCoords(set)) {
        const auto place_in_image = uv_map(*material);
        for (std::size_t i = 0; i < vertices; ++i)
            made.uvs.push_back(place_in_image(part.mTextureCoords[set][i]));
    }
    // Converted to linear: those of glTF already are, others are assumed to be sRGB.
    if (part.HasVertexColors(0))
        for (std::size_t i = 0; i < vertices; ++i) {
            const aiColor4D& colour = part.mColors[0][i];
            made.colours.push_back(
                is_gltf ? Rgb(colour.r, colour.g, colour.b)
                        : Rgb(srgb_decoded(colour.r), srgb_decoded(colour.g), srgb_decoded(colour.b)));
        }
    const std::span<const aiFace> faces(part.mFaces, part.mNumFaces);
    const bool only_triangles =
        std::ranges::all_of(faces, [](const aiFace& face) { return face.mNumIndices == 3; });
    for (const aiFace& face : faces) {
        if (!only_triangles) made.face_corners.push_back(face.mNumIndices);
        made.corners.insert(made.corners.end(), face.mIndices, face.mIndices + face.mNumIndices);
    }
    return made;
}

/// Reads a file in this process, on the stack of this thread.
Result<ModelContent> imported_content(std::string_view bytes, const std::filesystem::path& file,
                                      ModelFormat format) {
    const bool is_gltf = format == ModelFormat::gltf || format == ModelFormat::glb;
    std::string mended;
    if (format == ModelFormat::obj) {
        mended = with_leading_zeros(std::string(bytes));
        bytes = mended;
    }
    const AssimpFormat by_assimp = assimp_format(format);
    // assimp selects its importer by the extension.
    const std::string name = (file.parent_path() / (file.stem().string() + by_assimp.ending)).string();
    Assimp::Importer importer;
    keep_importer(importer, by_assimp.importer);
    importer.SetIOHandler(new FolderIoSystem(name, bytes, format));  // owned by the importer
    // no post-processing, because it does not validate indices and coordinates
    const aiScene* const read = importer.ReadFile(name, 0);
    if (!read) {
        // assimp catches exceptions, and would report lack of memory as `std::bad_alloc`.
        if (const std::exception_ptr& thrown = importer.GetException()) try {
                std::rethrow_exception(thrown);
            } catch (const std::bad_alloc&) {
                throw;
            } catch (const std::exception&) {
            }
        const std::string words = importer.GetErrorString();
        return Error{"", words.empty() ? "assimp reports no reason" : words};
    }

    const aiScene& scene = *read;
    ModelContent content;
    for (unsigned i = 0; i < scene.mNumMaterials; ++i)
        content.materials.push_back(content_of(scene, *scene.mMaterials[i]));
    for (unsigned i = 0; i < scene.mNumMeshes; ++i)
        content.meshes.push_back(content_of(scene, *scene.mMeshes[i], is_gltf));
    for_each_node(scene, [&](const aiNode& node, const aiMatrix4x4& transform) {
        std::vector<std::uint32_t> meshes = meshes_of(scene, node);
        if (!meshes.empty())
            content.nodes.push_back({node.mName.C_Str(), rows_of(transform), std::move(meshes)});
    });
    content.camera = camera_of(scene, is_gltf);
    if (is_gltf) content.lights = lights_of(scene);
    if (format == ModelFormat::obj) {
        content.listing = obj_listing(bytes);
        number_obj_vertices(*content.listing, content.meshes);
    }
    return content;
}

constexpr std::string_view task_name = "model 2";  // incremented whenever write_content changes

/// details: the number of the format, then the file's path.
Result<Done> read_model(std::string_view bytes, std::string_view details, ByteSink& answer) {
    if (details.empty()) return Error{"", "no format"};
    HF_TRY(const ModelContent content,
           assimp_content(bytes, details.substr(1), static_cast<ModelFormat>(details[0])));
    write_content(content, answer);
    return Done{};
}

/// Returns the folder of the files that a model may refer to.
std::string model_folder(std::string_view details) {
    if (details.empty()) return "";
    return std::filesystem::path(details.substr(1)).parent_path().string();
}

}  // namespace

Result<ModelContent> assimp_content(std::string_view bytes, const std::filesystem::path& file,
                                    ModelFormat format) {
    if (format != ModelFormat::gltf && format != ModelFormat::glb)
        return imported_content(bytes, file, format);
    HF_TRY(const GltfDepth depth, check_gltf(bytes, format == ModelFormat::glb));
    // assimp 5.2 reads, converts and deletes nodes recursively, with 480 bytes of stack per level (measured).
    constexpr std::size_t ordinary_depth = 256, stack = std::size_t{8} << 20, stack_per_level = 2048;
    if (depth.nodes <= ordinary_depth) return imported_content(bytes, file, format);
    Result<ModelContent> content = Error{};
    call_with_stack(stack + stack_per_level * depth.nodes,
                    [&] { content = imported_content(bytes, file, format); });
    return content;
}

Result<ModelContent> guarded_content(std::string_view bytes, const std::filesystem::path& file,
                                     ModelFormat format) {
    std::error_code code;
    const std::filesystem::path whole = std::filesystem::absolute(file, code);
    if (code) return Error{"", code.message()};
    HF_TRY(const bool apart, reads_apart());
    if (!apart) {
        try {
            return assimp_content(bytes, whole, format);
        } catch (const std::exception& error) {  // assimp throws for some damaged files
            return Error{"", exception_message(error)};
        }
    }
    constexpr double memory_per_byte = 60;
    const std::string details = static_cast<char>(format) + whole.string();
    HF_TRY(const MappedFile answer,
           read_apart(task_name, bytes, details, reader_limits(bytes.size(), memory_per_byte), ""));
    return content_from(answer.bytes);
}

ReaderTask model_reader_task() {
    return {task_name, read_model, model_folder};
}

}  // namespace haarfield
