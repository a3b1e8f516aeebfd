#include "shading/transfer/concentrated_light.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "fields/wavelets/haar_transform.h"
#include "shading/walk/cell_path.h"

namespace haarfield {
namespace {

constexpr std::size_t cells_a_face = wide_cells * wide_cells, most_sources = 2;
constexpr float side_by_side = 0.98f;  ///< Cosine of the angle within which cells form one source.

/// D, by channel.
using Moments = std::array<Vec3f, 3>;

float energy(const Moments& moments) {
    return moments[0].length2() + moments[1].length2() + moments[2].length2();
}

/// Returns the moments of all cells by face, in the order of the blocks of level 2, whose squares the cells
/// are.
std::vector<Moments> cell_moments(const DenseCoefficients& light, const DenseCoefficients& directions) {
    const BlockNumbers numbers(light.face_size);
    const Vec3f zero(0.0f);
    std::vector<Moments> moments(cubemap_faces * cells_a_face, {zero, zero, zero});
    for (int level = 2; level < numbers.levels(); ++level)
        for (std::size_t face = 0; face < cubemap_faces; ++face)
            for (std::size_t block = 0; block < std::size_t(1) << (4 * level); ++block) {
                Moments& cell = moments[face * cells_a_face + (block >> (4 * (level - 2)))];
                const std::size_t first = numbers(level, face, block) * wide_cells;
                for (std::size_t i = first; i < first + wide_cells; ++i) {
                    const auto& [x, y, z, unused] = directions.values[i];
                    for (std::size_t c = 0; c < 3; ++c) cell[c] += Vec3f(x, y, z) * light.values[i][c];
                }
            }
    return moments;
}

/// Returns the cells with important moments, the largest first.
std::vector<std::uint32_t> chosen_cells(std::span<const Moments> moments, double allowed) {
    std::vector<double> energies;
    for (const Moments& cell : moments) energies.push_back(double(energy(cell)));
    const double sum = std::accumulate(energies.begin(), energies.end(), 0.0);
    if (sum <= allowed) return {};
    return largest_energies(energies, static_cast<float>(std::sqrt(allowed / sum)));
}

/// Returns the direction of a cell's centre.
Vec3f direction_of(std::size_t cell) {
    const auto [column, row] = square_place(cell % cells_a_face);
    const auto coordinate = [](std::size_t i) { return (static_cast<float>(i) + 0.5f) / 8 - 1; };
    return cubemap_direction<Vec3f>(static_cast<int>(cell / cells_a_face), coordinate(column),
                                    coordinate(row))
        .normalized();
}

/// Calls add(index, value) for the coefficients of the function whose inner products are means over a cell.
template <class Add>
void for_each_coefficient_of_mean(const BlockNumbers& numbers, std::size_t cell, const Add& add) {
    const std::size_t face = cell / cells_a_face, path = cell % cells_a_face;
    const auto index = [](std::size_t block, std::size_t slot) {
        return static_cast<std::uint32_t>(block * wide_cells + slot);
    };
    add(index(numbers(0, face, 0), 0), 1.0f);
    const std::array<std::size_t, 2> blocks{numbers(0, face, 0), numbers(1, face, path / wide_cells)},
        cells{path / wide_cells, path % wide_cells};
    for (std::size_t level = 0; level < 2; ++level)
        for (std::size_t kind = 0; kind < 3; ++kind) {
            const std::size_t quadrant = cells[level] / 4, below = cells[level] % 4;
            const float scale = level == 0 ? 1 : 4;  // 2^(level of the quadtree).
            add(index(blocks[level], 4 * (kind + 1)), scale * wavelet_sign[kind][quadrant]);
            add(index(blocks[level], 4 * quadrant + kind + 1), 2 * scale * wavelet_sign[kind][below]);
        }
}

ConcentratedLight source_of(std::span<const std::uint32_t> cells, std::span<const Moments> moments,
                            const BlockNumbers& numbers) {
    ConcentratedLight source{Vec3f(0.0f), Rgb(0.0f), {}};
    std::map<std::uint32_t, Vec3f> sums;
    float squares = 0;
    for (const std::uint32_t cell : cells) {
        const Moments& of_cell = moments[cell];
        const Vec3f grey = (of_cell[0] + of_cell[1] + of_cell[2]) / 3;
        for (int c = 0; c < 3; ++c) source.colour[c] += of_cell[std::size_t(c)].dot(grey);
        squares += grey.length2();
        source.direction += direction_of(cell) * std::sqrt(energy(of_cell));
        for_each_coefficient_of_mean(numbers, cell, [&](std::uint32_t index, float value) {
            sums.try_emplace(index, 0.0f).first->second += grey * value;
        });
    }
    source.direction.normalize();
    source.colour /= std::max(squares, std::numeric_limits<float>::min());
    for (const auto& [index, sum] : sums) {
        source.moments.index.push_back(index);
        source.moments.value.push_back({sum.x, sum.y, sum.z, 0});
    }
    return source;
}

}  // namespace

DenseCoefficients direction_coefficients(int face_size) {
    std::vector<Rgb> texels;
    for (const Vec3f& direction : texel_directions(face_size)) texels.emplace_back(direction);
    return dense_coefficients(haar_cubemap<Rgb>(texels, face_size), face_size);
}

std::vector<ConcentratedLight> concentrated_light(const DenseCoefficients& light,
                                                  const DenseCoefficients& directions, float error) {
    assert(light.face_size == directions.face_size);
    const BlockNumbers numbers(light.face_size);
    if (numbers.levels() < 3) return {};
    Rgb flux(0.0f);
    for (std::size_t face = 0; face < cubemap_faces; ++face) {
        const auto& [red, green, blue, unused] = light.values[numbers(0, face, 0) * wide_cells];
        flux += Rgb(red, green, blue);
    }
    const std::vector<Moments> moments = cell_moments(light, directions);
    std::vector<std::uint32_t> left = chosen_cells(moments, squared(flux) * squared(error / 4));
    std::vector<ConcentratedLight> sources;
    while (!left.empty() && sources.size() < most_sources) {
        const Vec3f largest = direction_of(left[0]);
        const auto others = std::stable_partition(left.begin(), left.end(), [&](std::uint32_t cell) {
            return direction_of(cell).dot(largest) > side_by_side;
        });
        sources.push_back(source_of({left.begin(), others}, moments, numbers));
        left.erase(left.begin(), others);
    }
    return sources;
}

}  // namespace haarfield
