#include "tests/example_meshes.h"

namespace haarfield {
namespace {

/// A grid of cells x cells over the parallelogram at `corner`, facing along_x cross along_y.
void add_grid(Mesh& mesh, const Vec3f& corner, const Vec3f& along_x, const Vec3f& along_y, int cells) {
    const Vec3f normal = along_x.cross(along_y).normalized();
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    const auto side = static_cast<std::uint32_t>(cells + 1);
    for (int y = 0; y <= cells; ++y)
        for (int x = 0; x <= cells; ++x) {
            mesh.positions.push_back(corner + along_x * (static_cast<float>(x) / static_cast<float>(cells)) +
                                     along_y * (static_cast<float>(y) / static_cast<float>(cells)));
            mesh.normals.push_back(normal);
            mesh.vertex_materials.push_back(0);
        }
    for (std::uint32_t y = 0; y + 1 < side; ++y)
        for (std::uint32_t x = 0; x + 1 < side; ++x) {
            const std::uint32_t v = first + y * side + x;
            mesh.triangles.push_back({v, v + 1, v + side + 1});
            mesh.triangles.push_back({v, v + side + 1, v + side});
        }
}

}  // namespace

Mesh square_mesh(float side, float height, int cells) {
    Mesh mesh;
    mesh.material_names = {""};
    add_grid(mesh, {-side / 2, height, -side / 2}, {0, 0, side}, {side, 0, 0}, cells);
    return mesh;
}

Mesh upright_square_mesh(float half_edge, int cells) {
    Mesh mesh;
    mesh.material_names = {""};
    add_grid(mesh, {-half_edge, -half_edge, 0}, {2 * half_edge, 0, 0}, {0, 2 * half_edge, 0}, cells);
    return mesh;
}

Mesh box_mesh(const Vec3f& lower, const Vec3f& upper, int cells) {
    Mesh mesh;
    mesh.material_names = {""};
    const Vec3f x(upper.x - lower.x, 0, 0), y(0, upper.y - lower.y, 0), z(0, 0, upper.z - lower.z);
    add_grid(mesh, lower + x, y, z, cells);
    add_grid(mesh, lower, z, y, cells);
    add_grid(mesh, lower + y, z, x, cells);
    add_grid(mesh, lower, x, z, cells);
    add_grid(mesh, lower + z, x, y, cells);
    add_grid(mesh, lower, y, x, cells);
    return mesh;
}

Mesh sphere_mesh(const Vec3f& centre, float radius, int segments) {
    Mesh mesh;
    mesh.material_names = {""};
    const int rows = segments, columns = 2 * segments;
    const auto add = [&](double inclination, double azimuth) {
        const Vec3f n(static_cast<float>(std::sin(inclination) * std::cos(azimuth)),
                      static_cast<float>(std::cos(inclination)),
                      static_cast<float>(std::sin(inclination) * std::sin(azimuth)));
        mesh.normals.push_back(n);
        mesh.positions.push_back(centre + n * radius);
        mesh.vertex_materials.push_back(0);
    };
    add(0, 0);
    for (int row = 1; row < rows; ++row)
        for (int column = 0; column < columns; ++column) add(pi * row / rows, 2 * pi * column / columns);
    add(pi, 0);
    const auto vertex = [&](int row, int column) {
        if (row == 0) return 0u;
        if (row == rows) return static_cast<std::uint32_t>(mesh.positions.size() - 1);
        return static_cast<std::uint32_t>(1 + (row - 1) * columns + column % columns);
    };
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) {
            if (row > 0)
                mesh.triangles.push_back(
                    {vertex(row, column), vertex(row, column + 1), vertex(row + 1, column)});
            if (row + 1 < rows)
                mesh.triangles.push_back(
                    {vertex(row, column + 1), vertex(row + 1, column + 1), vertex(row + 1, column)});
        }
    return mesh;
}

Mesh joined_meshes(const Mesh& a, const Mesh& b) {
    Mesh mesh = a;
    append_mesh(mesh, b);
    return mesh;
}

PreparedMesh prepared_as_is(const Mesh& mesh) {
    return {.original = mesh, .backs = {}, .fine = mesh, .coarse = mesh, .findings = {}};
}

}  // namespace haarfield
