#pragma once
/// What a library has read of a model's file: plain arrays, which a process can hand to another.

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

/// Faces of one material, in their own frame. Coordinates and corners are the file's, and may be anything.
struct ContentMesh {
    static constexpr std::uint32_t no_material = UINT32_MAX;

    std::string name;
    std::uint32_t material = no_material;     ///< Index in ModelContent::materials, or no_material.
    std::vector<Vec3f> positions, normals;    ///< As many normals as positions, or none.
    std::vector<Vec2f> uvs;                   ///< Of the material's image; as many, or none.
    std::vector<Rgb> colours;                 ///< Linear; as many, or none.
    std::vector<std::uint32_t> face_corners;  ///< How many each face has; empty: three each.
    std::vector<std::uint32_t> corners;       ///< Of all faces: positions.
    /// Of OBJ: which vertices and faces of ModelContent::listing these are. A number for each position,
    /// not_original where none was found; faces as many as were found.
    std::vector<std::int32_t> numbers;
    std::vector<std::uint32_t> faces;
};

/// The vertices and faces of a file whose meshes have them in another order: OBJ.
struct ContentListing {
    std::vector<Vec3f> positions;             ///< Any numbers.
    std::vector<std::uint32_t> corners;       ///< Of all faces: positions.
    std::vector<std::uint32_t> face_corners;  ///< How many each face has.
};

/// A material, of which the images' files are not yet looked for.
struct ContentMaterial {
    std::string name;
    MeshMaterial description;
    std::vector<std::string> unused;  ///< What there is that haarfield does not use.
};

/// Meshes that stand somewhere.
struct ContentNode {
    std::string name;
    std::array<float, 16> transform{};  ///< To the file's world: rows, which stand before columns.
    std::vector<std::uint32_t> meshes;  ///< Indices in ModelContent::meshes; at least one.
};

struct ModelContent {
    std::vector<ContentMesh> meshes;
    std::vector<ContentMaterial> materials;
    std::vector<ContentNode> nodes;  ///< In the order of the file.
    std::optional<ModelCamera> camera;
    std::vector<ModelLight> lights;  ///< Of kind, place, colour and angles; the rest is as ModelLight has it.
    std::optional<ContentListing> listing;  ///< Of OBJ.
};

/// Whether a light's numbers are of one: finite, none negative, a direction, angles in their order below pi.
bool is_light(const ModelLight& light);

/// As bytes, in pieces.
void write_content(const ModelContent& content, ByteSink& sink);

/// From these, of which nothing is believed.
///
/// errors  (with an empty `where`) less or more than there should be; numbers out of their range.
Result<ModelContent> content_from(std::string_view bytes);

}  // namespace haarfield
