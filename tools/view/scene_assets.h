#pragma once
/// What pages fetch once: meshes, images over them, frames of colours as bytes. All little-endian.

#include "tools/view/live_scene.h"

#include <nlohmann/json_fwd.hpp>

namespace haarfield {

/// A mesh, its triangles sorted by material: 32 bit numbers of vertices and triangles, 1 or 0 for whether
/// there are texture coordinates, and of materials; the first triangle of each material; positions and
/// texture coordinates as floats; vertices of triangles as 32 bit numbers.
std::string mesh_bytes(const Mesh& mesh);

/// What pages are told of an entity: its parts, by material.
nlohmann::json json_of(const SceneEntity& entity, std::size_t number, const Entity& description);

/// The names of the scene's materials of an entity's parts; null: the part has its model's own.
nlohmann::json part_materials(const SceneEntity& entity, const Entity& description);

/// How exact colours are.
enum class Exactness : std::uint32_t {
    moving = 0,  ///< By vectors, coarser.
    quick = 1,   ///< In full, past other objects by their fields.
    exact = 2,   ///< What `bake` makes.
};

/// What stands before the colours of a frame.
struct FrameHead {
    std::uint32_t frame = 0;    ///< Its number, from 1.
    std::uint32_t message = 0;  ///< The number of the last message of the steering page that it shows.
    Exactness exactness = Exactness::moving;
    float milliseconds = 0;  ///< From that message's arrival to the frame.
};

/// A frame: "HFF1", the head's four values, the number of objects; of each its id, vertices, and 1 or 0 for
/// whether there are colours on top; then half floats, three a vertex, padded to whole 4 bytes, and as many
/// for what is on top.
std::string frame_bytes(const FrameHead& head, const Design& design,
                        const std::map<std::uint32_t, VertexColours>& colours);

}  // namespace haarfield
