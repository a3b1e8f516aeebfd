#pragma once
/// Decomposes the affine transform of an instance into a Placement and a shape of its mesh.
///
/// world = placement(shape(object)). Shading supports placements only: rotation, uniform scale, translation.
/// Non-uniform scale, shear and mirroring make a separate mesh with its own field.

#include "fields/base/placement.h"
#include "fields/base/result.h"
#include "fields/mesh/listed_mesh.h"
#include "fields/mesh/mesh.h"

#include <string>

namespace haarfield {

/// A linear map that scales along three orthogonal axes, by 1 along the longest, and may negate x before. It
/// contains no rotation. Elements are multiples of 2^-32, so that rounding does not create new shapes.
struct Shape {
    std::array<Vec3d, 3> row{Vec3d(1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, 0, 1)};

    /// Applies the shape to a point of the object.
    Vec3d operator()(const Vec3d& point) const {
        return {row[0].dot(point), row[1].dot(point), row[2].dot(point)};
    }
    bool operator==(const Shape&) const = default;
};

/// Relative tolerance of equal shapes: matrices in files have about six digits.
inline constexpr double shape_tolerance = 1e-5;

/// Tests whether a shape turns right-handed coordinates into left-handed ones.
bool mirrors(const Shape& shape);

/// Tests whether two shapes differ by at most shape_tolerance.
bool is_same_shape(const Shape& a, const Shape& b);

/// Returns eight hexadecimal digits, a hash of all elements, for use in file names.
std::string shape_name(const Shape& shape);

/// A linear map as a placement without translation, and a shape.
struct PlacedShape {
    Placement placement;
    Shape shape;
};

inline constexpr double least_stretch = 1e-6;  ///< Least scale factor of an affine transform.
inline constexpr double most_stretch = 1e6;    ///< Largest scale factor of an affine transform.

/// Largest ratio of two scale factors of an affine transform.
inline constexpr double most_stretch_ratio = 1e4;

/// Decomposes a linear map, given by its rows: the polar decomposition. The placement's scale is the largest
/// scale factor.
///
/// Maps that differ by a subsequent rotation have equal shapes up to rounding. If all scale factors agree up
/// to shape_tolerance, the shape is exactly Shape(), or the one that negates x if the map mirrors. A multiple
/// of the identity gives exactly that scale and no rotation.
///
/// accuracy  placement(shape(v)) equals the map's v within shape_tolerance where a shape is rounded to a
///           uniform one; else within 1e-7 of the largest scale factor.
/// errors    (without a place) scale factors beyond the limits above, including singular maps and NaN.
Result<PlacedShape> placed_shape(const std::array<Vec3d, 3>& row);

/// Applies a shape to positions and normals (by the inverse transpose). Triangles stay counter-clockwise;
/// those that lose their area by rounding remain. Shape() changes nothing.
Mesh shaped_mesh(Mesh mesh, const Shape& shape);

/// Applies a shape to the vertices and faces of a file; positions are bit-identical to shaped_mesh. Mirrored
/// faces are reversed but keep their first corner.
ListedMesh shaped_listing(ListedMesh listed, const Shape& shape);

}  // namespace haarfield
