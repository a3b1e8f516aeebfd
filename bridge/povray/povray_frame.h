#pragma once
/// What meshes that glow have in common in POV-Ray's words: their frame and their colours.

#include "bridge/povray/povray_scene.h"

namespace haarfield {

inline constexpr float largest_radiance =
    65000;  ///< POV-Ray keeps colours as floats, but its EXR holds halves.

using Colour = std::array<float, 3>;  ///< Linear RGB, in [0, largest_radiance].

/// Mixes a number's bits into a hash.
inline std::size_t mixed_hash(std::size_t hash, std::uint32_t bits) {
    return (hash ^ bits) * 0x9e3779b97f4a7c15u;
}

inline Rgb rgb(const Colour& colour) {
    return {colour[0], colour[1], colour[2]};
}

/// What a picture can hold, each colour by itself.
///
/// count  grows by the colours that were changed.
std::vector<Colour> clamped_colours(std::span<const Rgb> colours, std::uint64_t& count);

/// Appends a triangle's own uvs. Returns their numbers.
inline std::array<std::uint32_t, 3> append_corner_uvs(std::vector<Vec2f>& uvs,
                                                      const std::array<Vec2f, 3>& corners) {
    const auto first = static_cast<std::uint32_t>(uvs.size());
    uvs.insert(uvs.end(), corners.begin(), corners.end());
    return {first, first + 1, first + 2};
}

/// A mesh as POV-Ray interpolates well over it: turned, and magnified.
struct PovrayFrame {
    double magnified;
    Rotation rotation;

    explicit PovrayFrame(const Mesh& mesh);

    void append_vertices(std::string& text, const Mesh& mesh) const;  ///< vertex_vectors.
    void append_inverse(std::string& text) const;  ///< Takes turning and magnification back.
};

}  // namespace haarfield
