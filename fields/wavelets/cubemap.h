#pragma once
/// The cubemap: faces, texels, directions and solid angles. The latitude-longitude map.
///
/// Faces +x -x +y -y +z -z, with the layout of OpenEXR's ImfEnvmap.h. On a face, u points right and v down,
/// both in [-1, 1]. Texel (column, row) is centred at u = (2 column + 1)/size - 1, v = (2 row + 1)/size - 1.
///
///     face      0: +x   1: -x   2: +y   3: -y   4: +z   5: -z
///     direction (1,-v,u) (-1,-v,-u) (u,1,-v) (u,-1,v) (-u,-v,1) (u,-v,-1), to be normalised
///
/// Lat-long: x in [0,1] points right, y in [0,1] down; longitude = pi (1 - 2x), latitude = pi (1/2 - y),
/// direction = (sin lon cos lat, sin lat, cos lon cos lat): +z in the middle, -x right of it, +y on top.

#include "fields/base/vector.h"

#include <cstddef>
#include <vector>

namespace haarfield {

inline constexpr int cubemap_faces = 6;  ///< The number of faces.

/// True if a face may have `size` x `size` texels: a power of two up to 256. Scenes use 16 to 256; smaller
/// sizes are for small examples.
constexpr bool is_face_size(int size) {
    return size >= 1 && size <= 256 && (size & (size - 1)) == 0;
}

/// A point on the surface of the cube. u and v in [-1, 1].
struct CubemapPoint {
    int face = 0;
    double u = 0, v = 0;
};

/// Returns the direction of a point, not normalised: the component along the face's axis is +-1.
template <class Vec>
Vec cubemap_direction(int face, typename Vec::BaseType u, typename Vec::BaseType v) {
    switch (face) {
        case 0: return Vec(1, -v, u);
        case 1: return Vec(-1, -v, -u);
        case 2: return Vec(u, 1, -v);
        case 3: return Vec(u, -1, v);
        case 4: return Vec(-u, -v, 1);
        default: return Vec(u, -v, -1);
    }
}

/// Returns the point at which a direction of any non-zero length intersects the cube.
CubemapPoint cubemap_point(const Vec3d& direction);

/// Returns the unit vector to the centre of a texel.
Vec3f texel_direction(int face, int column, int row, int size);

/// Returns the centres of all texels, face by face in row-major order: 6 * size^2 unit vectors.
std::vector<Vec3f> texel_directions(int size);

/// Returns the exact solid angle of a texel. All texels of a cubemap sum to 4 pi. [sr]
double texel_solid_angle(int column, int row, int size);

/// Returns the unit vector of a point on the lat-long map.
Vec3d lat_long_direction(double x, double y);

/// The inverse of lat_long_direction: x in [0, 1), y in [0, 1].
void lat_long_point(const Vec3d& direction, double& x, double& y);

}  // namespace haarfield
