#pragma once
/// Cubemap faces by component, and outcodes of points relative to the faces' pyramids.

#include "fields/wavelets/cubemap.h"

namespace haarfield {

/// The frame of a face (cubemap.h) by component: u = sign[0] * direction[component[0]], and so on.
struct FaceComponents {
    int component[3];  ///< The axes of u, v and w, where w is along the face's axis.
    float sign[3];
};

/// Returns the components of a face.
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

/// Indexed by face.
inline const FaceComponents all_face_components[cubemap_faces] = {face_components(0), face_components(1),
                                                                  face_components(2), face_components(3),
                                                                  face_components(4), face_components(5)};

/// Outcodes. The pyramids of all faces are bounded by six planes, one for the sum and one for the difference
/// of each pair of coordinates. An outcode has one bit for each side of a plane: bits 4 p to 4 p + 3 of pair
/// p (xy, xz, yz) are set if  a > b,  a < b,  a > -b,  a < -b.  A triangle misses a face if all of its
/// vertices are outside of one plane of its pyramid.
///
/// The bit of points below a surface's horizon:
inline constexpr int below_horizon = 1 << 12;

/// Returns the outcode of a direction.
inline unsigned outcode(const Vec3f& p) {
    const auto pair = [](float a, float b) {
        return unsigned(a > b) | unsigned(a < b) << 1 | unsigned(a > -b) << 2 | unsigned(a < -b) << 3;
    };
    return pair(p.x, p.y) | pair(p.x, p.z) << 4 | pair(p.y, p.z) << 8;
}

/// Returns the outcode bit of the plane that separates (u, v) from (u/2, v/2) on a face.
inline unsigned outside_bit(int face, float u, float v) {
    return outcode(cubemap_direction<Vec3f>(face, u, v)) &
           ~outcode(cubemap_direction<Vec3f>(face, u / 2, v / 2));
}
/// Returns the bits of directions to the left and to the right of a face.
inline unsigned outside_left_or_right(int face) {
    return outside_bit(face, -1.5f, 0) | outside_bit(face, 1.5f, 0);
}
/// Returns the bit of directions above a face.
inline unsigned outside_above(int face) {
    return outside_bit(face, 0, -1.5f);
}
/// Returns the bit of directions below a face.
inline unsigned outside_below(int face) {
    return outside_bit(face, 0, 1.5f);
}

}  // namespace haarfield
