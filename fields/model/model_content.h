#pragma once
/// The content of a model's file as plain arrays, which can be passed between processes.

#include "fields/base/byte_stream.h"
#include "fields/base/result.h"
#include "fields/mesh/mesh_material.h"
#include "fields/model/model_part.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace haarfield {

/// Faces of one material, in their own frame. Coordinates and corners are the file's and unverified.
struct ContentMesh {
    static constexpr std::uint32_t no_material = UINT32_MAX;

    std::string name;
    std::uint32_t material = no_material;     ///< Index in ModelContent::materials, or no_material.
    std::vector<Vec3f> positions, normals;    ///< As many normals as positions, or none.
    std::vector<Vec2f> uvs;                   ///< In the material's image; as many, or none.
    std::vector<Rgb> colours;                 ///< Linear; as many, or none.
    std::vector<std::uint32_t> face_corners;  ///< The number of corners of each face; empty: three each.
    std::vector<std::uint32_t> corners;       ///< Corners of all faces: indices of positions.
    /// For OBJ: the vertices and faces of ModelContent::listing. One number per position, not_original if
    /// there is none; and the faces that were found.
    std::vector<std::int32_t> numbers;
    std::vector<std::uint32_t> faces;
};

/// The vertices and faces of a file whose meshes store them in another order: OBJ.
struct ContentListing {
    std::vector<Vec3f> positions;             ///< Any numbers.
    std::vector<std::uint32_t> corners;       ///< Corners of all faces: indices of positions.
    std::vector<std::uint32_t> face_corners;  ///< The number of corners of each face.
};

/// A material whose image files have not been searched for.
struct ContentMaterial {
    std::string name;
    MeshMaterial description;
    std::vector<std::string> unused;  ///< Properties that haarfield does not use.
};

/// A placement of meshes.
struct ContentNode {
    std::string name;
    std::array<float, 16> transform{};  ///< To the file's world: a row-major matrix for column vectors.
    std::vector<std::uint32_t> meshes;  ///< Indices in ModelContent::meshes; at least one.
};

/// The content of a model's file.
struct ModelContent {
    std::vector<ContentMesh> meshes;
    std::vector<ContentMaterial> materials;
    std::vector<ContentNode> nodes;  ///< In the order of the file.
    std::optional<ModelCamera> camera;
    /// With kind, position, colour and angles; other members have their defaults.
    std::vector<ModelLight> lights;
    std::optional<ContentListing> listing;  ///< For OBJ.
};

/// Tests whether a light is valid: finite numbers, none negative, a direction, ordered angles below pi.
bool is_light(const ModelLight& light);

/// Writes a model's content as bytes.
void write_content(const ModelContent& content, ByteSink& sink);

/// Reads a model's content from untrusted bytes.
///
/// errors  (with an empty `where`) too few or too many bytes; numbers out of range.
Result<ModelContent> content_from(std::string_view bytes);

}  // namespace haarfield
