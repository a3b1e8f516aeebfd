#pragma once
/// Meshes and frames as bytes for pages. All values are little-endian.

#include "tools/view/live_scene.h"

#include <nlohmann/json_fwd.hpp>

namespace haarfield {

/// Returns a mesh with its triangles sorted by material: the numbers of vertices and triangles (32 bit), 1 or
/// 0 for texture coordinates, and the number of materials; the first triangle of each material; positions and
/// texture coordinates as floats; the vertices of triangles (32 bit).
std::string mesh_bytes(const Mesh& mesh);

/// Returns the description of an entity for pages: its parts, by material.
nlohmann::json json_of(const SceneEntity& entity, std::size_t number, const Entity& description);

/// Returns the names of the scene's materials of an entity's parts; null: the part has its model's material.
nlohmann::json part_materials(const SceneEntity& entity, const Entity& description);

/// The exactness of colours.
enum class Exactness : std::uint32_t {
    moving = 0,  ///< By transfer vectors, coarser.
    quick = 1,   ///< Shaded in full; occlusion by other objects from their fields.
    exact = 2,   ///< Identical to `bake`.
};

/// The data before the colours of a frame.
struct FrameHead {
    std::uint32_t frame = 0;    ///< Number of the frame, counted from 1.
    std::uint32_t message = 0;  ///< Number of the steering page's last message that the frame includes.
    Exactness exactness = Exactness::moving;
    float milliseconds = 0;  ///< From the arrival of that message to the frame.
};

/// Returns a frame: "HFF1", the four values of the head, and the number of objects. For each object follow
/// its id, its number of vertices, and 1 if it has added colours, otherwise 0. Then follow three half floats
/// per vertex, padded to 4 bytes, and if there are added colours, the same number of half floats for these.
std::string frame_bytes(const FrameHead& head, const Design& design,
                        const std::map<std::uint32_t, VertexColours>& colours);

}  // namespace haarfield
