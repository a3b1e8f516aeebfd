#include "shading/lobes.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>

namespace haarfield {
namespace {

/// Grid position <-> face coordinate, equal in angle.
double grid_coordinate(int index, int steps) {
    return std::tan(pi / 4 * (2.0 * index / steps - 1));
}
double grid_index(double coordinate, int steps) {
    return (std::atan(coordinate) * 4 / pi + 1) * 0.5 * steps;
}

/// Below this a lobe is taken as zero: less than what a half float can tell from zero beside its peak of 1.
constexpr float negligible = 1e-5f;

/// Grid cells for a lobe of this width: interpolation errs by about h^2 exponent / 8 of the peak.
int table_steps(float exponent) {
    return exponent <= 40 ? 32 : 64;
}

void fill_lobe_texels(float exponent, const Vec3f& direction, int size, const std::vector<Vec3f>& centres,
                      std::vector<float>& texels) {
    // A narrow lobe varies within a texel: then its mean is taken over 2 x 2 places.
    const bool narrow = exponent * 16 > static_cast<float>(size * size);
    const auto power = [exponent](float cosine) { return std::exp(exponent * std::log(cosine)); };
    const float least = std::exp(std::log(negligible) / exponent);
    const float least_of_texel =
        std::cos(std::min(3.14f, std::acos(least) + 1.5f / static_cast<float>(size)));
    for (std::size_t i = 0; i < texels.size(); ++i) {
        const float cosine = centres[i].dot(direction);
        texels[i] = 0;
        if (!narrow) {
            if (cosine > std::max(least, 1e-6f)) texels[i] = exponent == 1 ? cosine : power(cosine);
        } else if (cosine > least_of_texel) {
            const int face = static_cast<int>(i) / (size * size), row = static_cast<int>(i) / size % size,
                      column = static_cast<int>(i) % size;
            float sum = 0;
            for (int q = 0; q < 4; ++q) {
                const float c =
                    texel_direction(face, 2 * column + q % 2, 2 * row + q / 2, 2 * size).dot(direction);
                if (c > least) sum += power(c);
            }
            texels[i] = sum / 4;
        }
    }
}

}  // namespace

std::vector<float> lobe_texels(float exponent, const Vec3f& direction, int size) {
    const std::vector<Vec3f> centres = texel_directions(size);
    std::vector<float> texels(centres.size());
    fill_lobe_texels(exponent, direction, size, centres, texels);
    return texels;
}

Result<LobeTable> lobe_table(float exponent, int size, const Truncation& truncation,
                             const Progress& progress) {
    assert(exponent > 0 && exponent <= 1000 && is_face_size(size));
    LobeTable table;
    table.exponent = exponent;
    table.steps = table_steps(exponent);
    const auto side = static_cast<std::size_t>(table.steps) + 1;
    table.lobes.resize(cubemap_faces * side * side);
    const std::vector<Vec3f> centres = texel_directions(size);
    tbb::parallel_for(std::size_t(0), cubemap_faces * side, [&](std::size_t line) {
        std::vector<float> texels(centres.size());
        for (std::size_t column = 0; column < side; ++column) {
            if (progress.stop.stop_requested()) return;
            const Vec3d direction = cubemap_direction<Vec3d>(
                static_cast<int>(line / side), grid_coordinate(static_cast<int>(column), table.steps),
                grid_coordinate(static_cast<int>(line % side), table.steps));
            fill_lobe_texels(exponent, Vec3f(direction.normalized()), size, centres, texels);
            table.lobes[line * side + column] = haar_cubemap<float>(texels, size, truncation);
        }
    });
    if (progress.stop.stop_requested()) return Error{"", interrupted};
    return table;
}

CubemapTree interpolated_lobe(const LobeTable& table, const Vec3f& direction) {
    const CubemapPoint point = cubemap_point(Vec3d(direction));
    const double x = grid_index(point.u, table.steps), y = grid_index(point.v, table.steps);
    const int column = std::clamp(static_cast<int>(x), 0, table.steps - 1),
              row = std::clamp(static_cast<int>(y), 0, table.steps - 1);
    const auto fx = static_cast<float>(x - column), fy = static_cast<float>(y - row);
    const auto side = static_cast<std::size_t>(table.steps) + 1;
    const CubemapTree* corner =
        &table.lobes[(std::size_t(point.face) * side + std::size_t(row)) * side + std::size_t(column)];
    const CubemapTree* corners[4] = {corner, corner + 1, corner + side, corner + side + 1};
    const float weights[4] = {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy};
    CubemapTree lobe;
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        const Quadtree* trees[4];
        for (std::size_t k = 0; k < 4; ++k) trees[k] = &corners[k]->faces[face];
        lobe.faces[face] = weighted_sum<float>(trees, weights);
    }
    return lobe;
}

namespace {

/// Area of the part of the unit square where  a x + b y + c > 0, as a fraction.
double fraction_above(double a, double b, double c) {
    // Mirror the square until a, b >= 0: the line then leaves the corner (1,1) above.
    if (a < 0) {
        c += a;
        a = -a;
    }
    if (b < 0) {
        c += b;
        b = -b;
    }
    if (c >= 0) return 1;
    if (a + b + c <= 0) return 0;
    // Below the line: the triangle at (0,0) with legs -c/a and -c/b, without what sticks out of the square.
    const double low = -c, over_x = low - a, over_y = low - b;
    if (a < 1e-12 * b) return 1 - low / b;
    if (b < 1e-12 * a) return 1 - low / a;
    double twice_below = low * low;
    if (over_x > 0) twice_below -= over_x * over_x;
    if (over_y > 0) twice_below -= over_y * over_y;
    return std::clamp(1 - twice_below / (2 * a * b), 0.0, 1.0);
}

/// A square of the face, by its level's grid.
struct Square {
    std::uint32_t x, y;
};

Quadtree half_plane_tree(double along_u, double along_v, double constant, int size) {
    const auto fraction = [&](const Square& square, int level) {
        const double side = std::ldexp(2.0, -level);  // in u and v
        const double u = square.x * side - 1, v = square.y * side - 1;
        return fraction_above(along_u * side, along_v * side, along_u * u + along_v * v + constant);
    };
    Quadtree tree;
    const double mean = fraction({0, 0}, 0);
    tree.scaling = static_cast<float>(mean);
    if (mean == 0 || mean == 1) return tree;
    const int levels = std::countr_zero(unsigned(size));
    std::vector<Square> row{{0, 0}}, next;
    for (int level = 0; level < levels && !row.empty(); ++level) {
        const std::size_t next_first = tree.nodes.size() + row.size();
        next.clear();
        for (const Square& square : row) {
            double quadrant[4];
            std::uint32_t mask = 0;
            const std::size_t first = next_first + next.size();
            for (unsigned q = 0; q < 4; ++q) {
                const Square child{2 * square.x + (q & 1u), 2 * square.y + (q >> 1)};
                quadrant[q] = fraction(child, level + 1);
                if (level + 1 == levels || quadrant[q] == 0 || quadrant[q] == 1) continue;
                mask |= 1u << q;
                next.push_back(child);
            }
            Quadtree::Node node;
            for (std::size_t a = 0; a < 3; ++a)
                node.wavelet[a] = static_cast<float>(
                    0.25 * (wavelet_sign[a][0] * quadrant[0] + wavelet_sign[a][1] * quadrant[1] +
                            wavelet_sign[a][2] * quadrant[2] + wavelet_sign[a][3] * quadrant[3]));
            node.children = mask == 0 ? 0 : static_cast<std::uint32_t>(first << 4 | mask);
            tree.nodes.push_back(node);
        }
        row.swap(next);
    }
    return tree;
}

}  // namespace

CubemapTree half_space_tree(const Vec3f& normal, int size) {
    CubemapTree cubemap;
    const Vec3d n(normal);
    for (int face = 0; face < cubemap_faces; ++face) {
        const auto axis = cubemap_direction<Vec3d>(face, 0, 0);
        cubemap.faces[std::size_t(face)] =
            half_plane_tree(n.dot(cubemap_direction<Vec3d>(face, 1, 0) - axis),
                            n.dot(cubemap_direction<Vec3d>(face, 0, 1) - axis), n.dot(axis), size);
    }
    return cubemap;
}

}  // namespace haarfield
