#include "scenes/shape.h"

#include <Imath/ImathMatrix.h>
#include <Imath/ImathMatrixAlgo.h>
#include <fmt/format.h>

#include <algorithm>

namespace haarfield {

namespace {

using Imath::M33d;

constexpr double steps_per_unit = 4294967296.0;  // 2^32

M33d matrix_of(const std::array<Vec3d, 3>& row) {
    return {row[0].x, row[0].y, row[0].z, row[1].x, row[1].y, row[1].z, row[2].x, row[2].y, row[2].z};
}

std::array<Vec3d, 3> rows_of(const M33d& matrix) {
    std::array<Vec3d, 3> row;
    for (int i = 0; i < 3; ++i) row[std::size_t(i)] = Vec3d(matrix[i][0], matrix[i][1], matrix[i][2]);
    return row;
}

/// Returns the matrix that negates x.
M33d mirror() {
    return matrix_of({Vec3d(-1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, 0, 1)});
}

std::int64_t steps(double number) {
    return std::llround(number * steps_per_unit);
}

}  // namespace

bool is_same_shape(const Shape& a, const Shape& b) {
    const M33d from_b_to_a = matrix_of(a.row) * matrix_of(b.row).inverse();
    return from_b_to_a.equalWithAbsError(M33d(), shape_tolerance);
}

// Hash: FNV-1a.
std::string shape_name(const Shape& shape) {
    std::uint64_t hash = 0xcbf29ce484222325u;
    for (const Vec3d& row : shape.row)
        for (int axis = 0; axis < 3; ++axis) {
            const auto bits = static_cast<std::uint64_t>(steps(row[axis]));
            for (int byte = 0; byte < 8; ++byte) hash = (hash ^ (bits >> (8 * byte) & 255)) * 0x100000001b3u;
        }
    return fmt::format("{:08x}", static_cast<std::uint32_t>(hash ^ hash >> 32));
}

// Without the mirroring, the map is U S V^T = s (U V^T) (V S/s V^T): a rotation after a scaling along V.
Result<PlacedShape> placed_shape(const std::array<Vec3d, 3>& row) {
    const M33d given = matrix_of(row);
    const bool is_mirrored = given.determinant() < 0;
    M33d u, v;
    Vec3d stretch;
    Imath::jacobiSVD(is_mirrored ? given * mirror() : given, u, stretch, v);
    if (!(stretch[2] >= least_stretch && stretch[0] <= most_stretch &&
          stretch[0] <= most_stretch_ratio * stretch[2]))
        return Error{"",
                     fmt::format("has scale factors from {:.3g} to {:.3g}; expected {:g} to {:g}, the "
                                 "largest at most {:g} times the smallest",
                                 stretch[2], stretch[0], least_stretch, most_stretch, most_stretch_ratio)};

    PlacedShape parts;
    parts.placement.scale = static_cast<float>(stretch[0]);
    parts.placement.rotate.row = rows_of(u * v.transposed());
    const M33d symmetric = v *
                           matrix_of({Vec3d(1, 0, 0), Vec3d(0, stretch[1] / stretch[0], 0),
                                      Vec3d(0, 0, stretch[2] / stretch[0])}) *
                           v.transposed();
    Shape rounded;
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
            rounded.row[std::size_t(i)][k] =
                static_cast<double>(steps(0.5 * (symmetric[i][k] + symmetric[k][i]))) / steps_per_unit;
    if (!is_same_shape(rounded, Shape())) parts.shape = rounded;
    if (is_mirrored)
        for (Vec3d& of_shape : parts.shape.row) of_shape.x = -of_shape.x;
    return parts;
}

bool mirrors(const Shape& shape) {
    return matrix_of(shape.row).determinant() < 0;
}

Mesh shaped_mesh(Mesh mesh, const Shape& shape) {
    if (shape == Shape()) return mesh;
    const M33d matrix = matrix_of(shape.row);
    const Shape of_normals{rows_of(matrix.inverse().transposed())};
    for (Vec3f& position : mesh.positions) position = Vec3f(shape(Vec3d(position)));
    for (Vec3f& normal : mesh.normals) normal = Vec3f(of_normals(Vec3d(normal)).normalized());
    if (mirrors(shape))
        for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
    return mesh;
}

ListedMesh shaped_listing(ListedMesh listed, const Shape& shape) {
    if (shape == Shape()) return listed;
    for (Vec3f& position : listed.positions) position = Vec3f(shape(Vec3d(position)));
    if (!mirrors(shape)) return listed;
    auto corner = listed.corners.begin();
    for (const std::uint32_t count : listed.face_corners) {
        if (count > 0) std::reverse(corner + 1, corner + count);
        corner += count;
    }
    return listed;
}

}  // namespace haarfield
