#pragma once
/// What the two paths of the visibility rasterizer share: faces by components, outcodes, the sample pattern.

#include <array>
#include <cstdint>

#include "fields/rasterizer/visibility_rasterizer.h"
#include "fields/wavelets/cubemap.h"

namespace haarfield {

/// A face's frame (cubemap.h) as components: u = sign * direction[component], and so on.
struct FaceComponents {
    int component[3];  ///< Of u, v, and w, which is along the axis.
    float sign[3];
};

inline FaceComponents face_components(int face) {
    const auto axis = cubemap_direction<Vec3f>(face, 0, 0);
    const Vec3f frame[3] = {cubemap_direction<Vec3f>(face, 1, 0) - axis,
                            cubemap_direction<Vec3f>(face, 0, 1) - axis, axis};
    FaceComponents found{};
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
            if (frame[i][k] != 0) {
                found.component[i] = k;
                found.sign[i] = frame[i][k];
            }
    return found;
}

inline const FaceComponents all_face_components[cubemap_faces] = {face_components(0), face_components(1),
                                                                  face_components(2), face_components(3),
                                                                  face_components(4), face_components(5)};

// Outcodes. The pyramids of all faces have six planes, one for a sum and one for a difference of two
// coordinates; a bit for each side of them: bits 4 p to 4 p + 3 of pair p (xy, xz, yz) tell  a > b,  a < b,
// a > -b,  a < -b.  A triangle misses a face if all of its vertices are outside of one plane of its pyramid.
inline constexpr int below_horizon = 1 << 12;

inline unsigned outcode(const Vec3f& p) {
    const auto pair = [](float a, float b) {
        return unsigned(a > b) | unsigned(a < b) << 1 | unsigned(a > -b) << 2 | unsigned(a < -b) << 3;
    };
    return pair(p.x, p.y) | pair(p.x, p.z) << 4 | pair(p.y, p.z) << 8;
}

/// The bit of the side of a face's plane on which (u, v) lies and (u/2, v/2) does not.
inline unsigned outside_bit(int face, float u, float v) {
    return outcode(cubemap_direction<Vec3f>(face, u, v)) &
           ~outcode(cubemap_direction<Vec3f>(face, u / 2, v / 2));
}
inline unsigned outside_left_or_right(int face) {
    return outside_bit(face, -1.5f, 0) | outside_bit(face, 1.5f, 0);
}
inline unsigned outside_above(int face) {
    return outside_bit(face, 0, -1.5f);
}
inline unsigned outside_below(int face) {
    return outside_bit(face, 0, 1.5f);
}

/// Where in its texel column the sample of a sub-column lies, in texel rows; the inverse of the pattern's
/// sub-row offsets. Twice, so that a vector of 8 may start anywhere.
struct RowOffsets {
    std::array<float, 32> rows{};
    constexpr RowOffsets() {
        for (int sub_row = 0; sub_row < samples_per_texel; ++sub_row)
            for (std::size_t repeat = 0; repeat < 32; repeat += samples_per_texel) {
                const auto sub_column = static_cast<std::size_t>(sample_offset(sub_row) * samples_per_texel);
                rows[repeat + sub_column] = (static_cast<float>(sub_row) + 0.5f) / samples_per_texel;
            }
    }
};
inline constexpr RowOffsets row_offsets;

/// The bits of a word whose numbers, counted from `start`, are below `end`.
constexpr std::uint64_t bits_below(std::uint32_t end, std::uint32_t start) {
    if (end <= start) return 0;
    return end - start >= 64 ? ~std::uint64_t(0) : (std::uint64_t(1) << (end - start)) - 1;
}

}  // namespace haarfield
