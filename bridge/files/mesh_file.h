#pragma once
/// Writes the shaded scene as one mesh for any viewer, and as a table.

#include "bridge/povray/baked_scene.h"

namespace haarfield {

/// Writes all instances in world coordinates as one binary little-endian PLY file, atomically.
///
/// Vertex properties:
/// - x y z, nx ny nz (float).
/// - red green blue (8 bit, sRGB-encoded, clamped to [0, 1]): the colours that MeshLab, CloudCompare, Blender
///   and assimp display.
/// - radiance_r radiance_g radiance_b (float, linear, unclamped), for programs that process the values.
/// - instance (int), counted from 0 in the order of `instances`.
/// - original_vertex (int): the vertex number in the model file (Mesh::original_vertices), or -1 if
///   subdivision, refinement or the back of a sheet created the vertex.
/// - NAME_r NAME_g NAME_b of each pass, or NAME if it is one number (float).
///
/// Readers skip unknown properties. Faces are triangles, or those of BakedInstance::listed.
///
/// errors    as write_baked_scene; 2^31 vertices or more.
Result<Done> write_baked_ply(const std::filesystem::path& file, std::span<const BakedInstance> instances);

/// Writes a table of all vertices in world coordinates as CSV text, atomically.
///
/// The first line names the columns:
/// - instance: its name, quoted if necessary.
/// - vertex: counted from 0 in each instance, in the order of write_baked_ply.
/// - x y z, nx ny nz.
/// - radiance_r radiance_g radiance_b: linear, unclamped.
/// - the passes, named as in write_baked_ply.
///
/// Numbers have the fewest digits that restore the same floats.
///
/// errors  as write_baked_scene.
/// cost    about 110 bytes per vertex.
Result<Done> write_baked_csv(const std::filesystem::path& file, std::span<const BakedInstance> instances);

/// A file format of baked meshes.
struct MeshFormat {
    const char* name;     ///< On the command line, and the ending of file names.
    const char* summary;  ///< For --help and Python.
    /// Writes the instances to a file.
    Result<Done> (*write)(const std::filesystem::path& file, std::span<const BakedInstance> instances);
    bool has_images = false;  ///< The file has images of textures: OriginalBake::textured.
};

/// All formats; the first one is the default.
std::span<const MeshFormat> mesh_formats();

}  // namespace haarfield
