#pragma once
/// Any affine place of an instance, parted into a Placement and a shape of its mesh.
///
/// world = placement(shape(object)): all of shading has placements only, which turn, magnify alike along all
/// axes and translate. What is stretched or mirrored beyond that is another mesh, with a field of its own.

#include "fields/base/placement.h"
#include "fields/base/result.h"
#include "fields/mesh/listed_mesh.h"
#include "fields/mesh/mesh.h"

#include <string>

namespace haarfield {

/// A linear map that stretches along three axes at right angles to each other, by 1 along the longest, and
/// may negate x before. It turns nothing. Numbers are multiples of 2^-32: rounding makes no new shapes.
struct Shape {
    std::array<Vec3d, 3> row{Vec3d(1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, 0, 1)};

    /// A point of the object, stretched.
    Vec3d operator()(const Vec3d& point) const {
        return {row[0].dot(point), row[1].dot(point), row[2].dot(point)};
    }
    bool operator==(const Shape&) const = default;
};

/// How far lengths of equal shapes may differ, relatively: matrices in files have six digits or so.
inline constexpr double shape_tolerance = 1e-5;

/// Tests whether a shape turns right-handed coordinates into left-handed ones.
bool mirrors(const Shape& shape);

/// Whether no length differs by more than shape_tolerance.
bool is_same_shape(const Shape& a, const Shape& b);

/// Eight hexadecimal digits, a hash of all bits: part of a file's name.
std::string shape_name(const Shape& shape);

/// A linear map as a placement, which does not translate, and a shape.
struct LinearParts {
    Placement placement;
    Shape shape;
};

/// Limits of affine places: by how much they stretch lengths.
inline constexpr double least_stretch = 1e-6, most_stretch = 1e6, most_stretch_ratio = 1e4;

/// Parts a linear map, given by its rows: its polar decomposition. The placement magnifies by its largest
/// stretch.
///
/// Maps that differ by a rotation afterwards have the same shape, up to rounding. Of maps that stretch alike
/// along all axes, up to shape_tolerance, it is Shape() to the last bit, or the one that negates x if they
/// mirror. A multiple of the identity gives that scale and no rotation, to the last bit.
///
/// accuracy  placement(shape(v)) is the map's v within shape_tolerance where shapes are rounded to one that
///           stretches alike; else within 1e-7 of the largest stretch.
/// errors    (without a place) stretches beyond the limits above, singular maps and NaN among them.
Result<LinearParts> linear_parts(const std::array<Vec3d, 3>& row);

/// A mesh of that shape: positions; normals, by the inverse transposed; triangles counter-clockwise still.
/// Triangles that lose their area by rounding stay. Shape() leaves all bits.
Mesh shaped_mesh(Mesh mesh, const Shape& shape);

/// The same of what its file lists, with the same bits; faces of a shape that mirrors turn the other way,
/// from the same corner on.
ListedMesh shaped_listing(ListedMesh listed, const Shape& shape);

}  // namespace haarfield
