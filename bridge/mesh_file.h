#pragma once
/// The shaded scene as one mesh, for any viewer.

#include "bridge/baked_scene.h"

namespace haarfield {

/// Writes all instances, in world space, as one binary little-endian PLY; atomically.
///
/// Per vertex: x y z, nx ny nz (float); red green blue (8 bit, sRGB-encoded, clamped to [0, 1]), which
/// is what MeshLab, CloudCompare, Blender and assimp show; and radiance_r radiance_g radiance_b (float,
/// linear, unclamped), for programs that want the numbers. Readers skip what they do not know.
///
/// errors    as write_baked_scene; more than 2^31 vertices.
Result<Done> write_baked_ply(const std::filesystem::path& file, std::span<const BakedInstance> instances);

}  // namespace haarfield
