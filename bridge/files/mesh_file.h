#pragma once
/// The shaded scene as one mesh, for any viewer, and as a table.

#include "bridge/povray/baked_scene.h"

namespace haarfield {

/// Writes all instances, in world space, as one binary little-endian PLY; atomically.
///
/// Per vertex: x y z, nx ny nz (float); red green blue (8 bit, sRGB-encoded, clamped to [0, 1]), which is
/// what MeshLab, CloudCompare, Blender and assimp show; radiance_r radiance_g radiance_b (float, linear,
/// unclamped), for programs that want the numbers; instance (int), counted from 0 in the order of
/// `instances`; original_vertex (int), its number in the model's file (Mesh::original_vertices), or -1 where
/// it is none of the file's but made by subdivision, refinement or for the back of a sheet; and of each pass
/// NAME_r NAME_g NAME_b, or NAME if it is one number (float). Readers skip what they do not know. Faces are
/// triangles, or those of BakedInstance::listed.
///
/// errors    as write_baked_scene; more than 2^31 vertices.
Result<Done> write_baked_ply(const std::filesystem::path& file, std::span<const BakedInstance> instances);

/// Writes a table of all vertices, in world space, as text; atomically.
///
/// The first line names the columns: instance (its name, in double quotes if it needs them), vertex (counted
/// from 0 in each instance, in the order of write_baked_ply), x y z, nx ny nz, radiance_r radiance_g
/// radiance_b (linear, unclamped), and those of passes as write_baked_ply names them. Numbers are the
/// shortest that are read back as the same floats.
///
/// errors  as write_baked_scene.
/// cost    some 110 bytes a vertex.
Result<Done> write_baked_csv(const std::filesystem::path& file, std::span<const BakedInstance> instances);

/// A file format of baked meshes.
struct MeshFormat {
    const char* name;     ///< On the command line, and the ending of file names.
    const char* summary;  ///< For --help and Python.
    Result<Done> (*write)(const std::filesystem::path& file, std::span<const BakedInstance> instances);
    bool has_images = false;  ///< The file has images of textures: OriginalBake::textured.
};

/// All formats; the first one is the default.
std::span<const MeshFormat> mesh_formats();

}  // namespace haarfield
