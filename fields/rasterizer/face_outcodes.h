#pragma once
/// Cubemap faces by components, and outcodes: outside of which of their planes a point lies.

#include "fields/wavelets/cubemap.h"

namespace haarfield {

/// A face's frame (cubemap.h) as components: u = sign * direction[component], and so on.
struct FaceComponents {
    int component[3];  ///< Of u, v, and w, which is along the axis.
    float sign[3];
};

/// Of a face.
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

/// By face.
inline const FaceComponents all_face_components[cubemap_faces] = {face_components(0), face_components(1),
                                                                  face_components(2), face_components(3),
                                                                  face_components(4), face_components(5)};

/// Outcodes. The pyramids of all faces have six planes, one for a sum and one for a difference of two
/// coordinates; a bit for each side of them: bits 4 p to 4 p + 3 of pair p (xy, xz, yz) tell  a > b,  a < b,
/// a > -b,  a < -b.  A triangle misses a face if all of its vertices are outside of one plane of its pyramid.
/// And a bit for points below a surface's horizon:
inline constexpr int below_horizon = 1 << 12;

/// The outcode of a direction.
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
/// The bits of the face's planes on the left and on the right.
inline unsigned outside_left_or_right(int face) {
    return outside_bit(face, -1.5f, 0) | outside_bit(face, 1.5f, 0);
}
/// The bit of its plane above.
inline unsigned outside_above(int face) {
    return outside_bit(face, 0, -1.5f);
}
/// The bit of its plane below.
inline unsigned outside_below(int face) {
    return outside_bit(face, 0, 1.5f);
}

}  // namespace haarfield
