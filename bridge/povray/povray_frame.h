#pragma once
/// The frame and the colours of emissive meshes in POV-Ray's language.

#include "bridge/povray/povray_scene.h"

namespace haarfield {

/// The largest channel. POV-Ray stores colours as floats, but its EXR files contain half floats.
inline constexpr float largest_radiance = 65000;

using Colour = std::array<float, 3>;  ///< Linear RGB, in [0, largest_radiance].

/// Mixes a number's bits into a hash.
inline std::size_t mixed_hash(std::size_t hash, std::uint32_t bits) {
    return (hash ^ bits) * 0x9e3779b97f4a7c15u;
}

/// Converts a colour.
inline Rgb rgb(const Colour& colour) {
    return {colour[0], colour[1], colour[2]};
}

/// Returns colours with each channel clamped to what a picture can hold.
///
/// count  increases by the number of colours that change.
std::vector<Colour> clamped_colours(std::span<const Rgb> colours, std::uint64_t& count);

/// Appends the uvs of a triangle's corners. Returns their indices.
inline std::array<std::uint32_t, 3> append_corner_uvs(std::vector<Vec2f>& uvs,
                                                      const std::array<Vec2f, 3>& corners) {
    const auto first = static_cast<std::uint32_t>(uvs.size());
    uvs.insert(uvs.end(), corners.begin(), corners.end());
    return {first, first + 1, first + 2};
}

/// Rotation and magnification of a mesh, which POV-Ray needs to interpolate accurately.
struct PovrayFrame {
    double magnified;
    Rotation rotation;

    /// Finds both; see small_triangle_scale and interpolation_rotation.
    explicit PovrayFrame(const Mesh& mesh);

    void append_vertices(std::string& text, const Mesh& mesh) const;  ///< Appends vertex_vectors.
    void append_normals(std::string& text, const Mesh& mesh) const;   ///< Appends normal_vectors.
    void append_inverse(std::string& text) const;  ///< Appends the transformation back to the mesh's frame.
};

}  // namespace haarfield
