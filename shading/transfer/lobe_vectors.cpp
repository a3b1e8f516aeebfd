#include "shading/transfer/lobe_vectors.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <memory>
#include <set>

#include "fields/wavelets/haar_transform.h"
#include "shading/scene/lobes.h"

namespace haarfield {
namespace {

/// Convert between grid position and face coordinate, equiangular.
double grid_coordinate(int index, int steps) {
    return std::tan(pi / 4 * (2.0 * index / steps - 1));
}
double grid_index(double coordinate, int steps) {
    return (std::atan(coordinate) * 4 / pi + 1) * 0.5 * steps;
}

/// A symmetry of the cube: axis k maps to `sign[k]` times axis `to[k]`.
struct Symmetry {
    std::array<int, 3> to{0, 1, 2};
    std::array<int, 3> sign{1, 1, 1};

    Vec3d operator()(const Vec3d& v) const {
        Vec3d result;
        for (int k = 0; k < 3; ++k) result[to[std::size_t(k)]] = v[k] * sign[std::size_t(k)];
        return result;
    }
    auto operator<=>(const Symmetry&) const = default;
};

/// Returns the symmetry that maps a direction with  x >= y >= z >= 0  to the given one.
Symmetry symmetry_to(const Vec3d& direction) {
    Symmetry symmetry;
    std::stable_sort(symmetry.to.begin(), symmetry.to.end(),
                     [&](int a, int b) { return std::abs(direction[a]) > std::abs(direction[b]); });
    for (std::size_t k = 0; k < 3; ++k) symmetry.sign[k] = direction[symmetry.to[k]] < 0 ? -1 : 1;
    return symmetry;
}

/// Returns the index of a wavelet's coefficient (sparse_vectors.h).
std::uint32_t wavelet_index(const BlockNumbers& numbers, int face, int level, int x, int y,
                            std::uint32_t kind) {
    std::uint32_t square = 0;  // Its Morton number.
    for (int bit = level - 1; bit >= 0; --bit)
        square = square << 2 | (std::uint32_t(y) >> bit & 1u) << 1 | (std::uint32_t(x) >> bit & 1u);
    const bool is_quadrant = level % 2 == 1;
    const std::size_t block = numbers(level / 2, std::size_t(face), is_quadrant ? square >> 2 : square);
    const std::uint32_t slot = is_quadrant ? 4 * (square & 3u) + 1 + kind : 4 * (1 + kind);
    return static_cast<std::uint32_t>(block * wide_cells) + slot;
}

/// The image of a coefficient: its index, and its sign.
struct Image {
    std::uint32_t index;
    float sign;
};

/// Returns the image of each coefficient under a symmetry.
///
/// On a face the symmetry maps (u, v) to another face's (u', v'), where u' is +-u or +-v. Relative to the
/// centre of their square the wavelets are -sgn u, -sgn v and sgn u sgn v (quadtree.h), so they exchange
/// places and signs accordingly.
std::vector<Image> images(const Symmetry& symmetry, int face_size) {
    std::vector<Image> result(coefficient_count(face_size), Image{0, 0});
    const BlockNumbers numbers(face_size);
    for (int face = 0; face < cubemap_faces; ++face) {
        const auto right_of = [](int f) {
            return cubemap_direction<Vec3d>(f, 1, 0) - cubemap_direction<Vec3d>(f, 0, 0);
        };
        const auto down_of = [](int f) {
            return cubemap_direction<Vec3d>(f, 0, 1) - cubemap_direction<Vec3d>(f, 0, 0);
        };
        const int target = cubemap_point(symmetry(cubemap_direction<Vec3d>(face, 0, 0))).face;
        const Vec3d right = symmetry(right_of(face)), down = symmetry(down_of(face));
        const auto u_of_u = static_cast<int>(right.dot(right_of(target))),
                   u_of_v = static_cast<int>(down.dot(right_of(target))),
                   v_of_u = static_cast<int>(right.dot(down_of(target))),
                   v_of_v = static_cast<int>(down.dot(down_of(target)));
        const bool transposed = u_of_u == 0;
        const std::array<std::uint32_t, 3> kind =
            transposed ? std::array<std::uint32_t, 3>{1, 0, 2} : std::array<std::uint32_t, 3>{0, 1, 2};
        const auto sign_u = static_cast<float>(u_of_u + u_of_v), sign_v = static_cast<float>(v_of_u + v_of_v);
        const std::array<float, 3> sign{transposed ? sign_v : sign_u, transposed ? sign_u : sign_v,
                                        sign_u * sign_v};
        const auto mean_of = [&](int f) {
            return static_cast<std::uint32_t>(numbers(0, std::size_t(f), 0) * wide_cells);
        };
        result[mean_of(face)] = {mean_of(target), 1};
        for (int level = 0; 1 << level < face_size; ++level) {
            const int side = 1 << level;
            for (int y = 0; y < side; ++y)
                for (int x = 0; x < side; ++x) {
                    // Twice the distance from the face's centre.
                    const int u = 2 * x + 1 - side, v = 2 * y + 1 - side;
                    const int new_x = (u_of_u * u + u_of_v * v + side - 1) / 2,
                              new_y = (v_of_u * u + v_of_v * v + side - 1) / 2;
                    for (std::uint32_t k = 0; k < 3; ++k)
                        result[wavelet_index(numbers, face, level, x, y, k)] = {
                            wavelet_index(numbers, target, level, new_x, new_y, kind[k]), sign[k]};
                }
        }
    }
    return result;
}

/// The grid's directions with x >= y >= z >= 0, numbered by their distances from the centre of face +x in
/// half steps.
class FirstDirections {
public:
    explicit FirstDirections(int steps) : steps_(steps) {}

    std::size_t count() const { return place(steps_ / 2, steps_ / 2) + 1; }

    /// Returns the number of a grid point or of its image.
    std::size_t of(int column, int row) const {
        const int a = std::abs(2 * column - steps_) / 2, b = std::abs(2 * row - steps_) / 2;
        return place(std::max(a, b), std::min(a, b));
    }
    Vec3f direction(std::size_t number) const {
        int larger = 0;
        while (place(larger, larger) < number) ++larger;
        const auto smaller = static_cast<int>(number - place(larger, 0));
        return Vec3f(Vec3d(1, grid_coordinate(steps_ / 2 + larger, steps_),
                           grid_coordinate(steps_ / 2 + smaller, steps_))
                         .normalized());
    }

private:
    static std::size_t place(int larger, int smaller) {
        return static_cast<std::size_t>(larger * (larger + 1) / 2 + smaller);
    }
    int steps_;
};

/// Drops the least important coefficients, as ProductPruning does.
LobeShapes::Coefficients pruned(const LobeShapes::Coefficients& lobe, const BlockNumbers& numbers,
                                const CoefficientSpectrum& factor, float error) {
    std::vector<double> energies;
    for (const auto& [index, value] : lobe) {
        const double matters = double(value) * double(factor[spectrum_place(numbers, index)]);
        energies.push_back(matters * matters);
    }
    LobeShapes::Coefficients result;
    for (const std::uint32_t i : largest_energies(energies, error)) result.push_back(lobe[i]);
    std::ranges::sort(result);  // Order of use: neighbours in index are neighbours in memory.
    return result;
}

}  // namespace

Result<LobeShapes> lobe_shapes(std::span<const float> exponents, int face_size, float error,
                               const Progress& progress) {
    LobeShapes result;
    result.face_size = face_size;
    const std::set<float> different(exponents.begin(), exponents.end());
    result.exponents.assign(different.begin(), different.end());
    const FirstDirections directions(result.steps);
    const std::vector<Vec3f> centres = texel_directions(face_size);
    result.lobes.resize(result.exponents.size() * directions.count());
    tbb::enumerable_thread_specific<CoefficientSum> sums([&] { return CoefficientSum(face_size); });
    tbb::parallel_for(std::size_t(0), result.lobes.size(), [&](std::size_t i) {
        if (progress.stop.stop_requested()) return;
        CoefficientSum& sum = sums.local();
        sum.clear();
        const std::vector<float> texels =
            lobe_texels(result.exponents[i / directions.count()],
                        directions.direction(i % directions.count()), face_size, centres);
        sum.add(haar_cubemap<float>(texels, face_size, {0, error}), 1);
        for (const std::uint32_t index : sum.indices()) result.lobes[i].emplace_back(index, sum[index]);
    });
    if (progress.stop.stop_requested()) return interruption();
    SpectrumEnergies energies{};
    const BlockNumbers numbers(face_size);
    for (const LobeShapes::Coefficients& lobe : result.lobes)
        for (const auto& [index, value] : lobe)
            energies[spectrum_place(numbers, index)] += double(value) * double(value);
    result.spectrum = root_mean_squares(energies, double(std::max<std::size_t>(1, result.lobes.size())));
    return result;
}

Result<LobeVectors> lobe_vectors(const LobeShapes& shapes, const CoefficientSpectrum& factor, float error,
                                 const Progress& progress) {
    LobeVectors result;
    result.steps = shapes.steps;
    const int side = result.steps + 1;
    const auto lobes_of_exponent = static_cast<std::uint32_t>(cubemap_faces * side * side);
    for (const float exponent : shapes.exponents) {
        const auto next = static_cast<std::uint32_t>(result.first.size()) * lobes_of_exponent;
        result.first.emplace(exponent, next);
    }
    result.lobes = SparseVectorBlocks(result.first.size() * lobes_of_exponent, shapes.face_size, 1);

    const FirstDirections first_directions(result.steps);
    const BlockNumbers numbers(shapes.face_size);
    std::vector<LobeShapes::Coefficients> first_lobes(shapes.lobes.size());
    tbb::parallel_for(std::size_t(0), first_lobes.size(), [&](std::size_t i) {
        if (progress.stop.stop_requested()) return;
        first_lobes[i] = pruned(shapes.lobes[i], numbers, factor, error);
    });

    if (progress.stop.stop_requested()) return interruption();
    std::map<Symmetry, std::vector<Image>> images_by_symmetry;
    const auto grid_direction = [&](int face, int row, int column) {
        return cubemap_direction<Vec3d>(face, grid_coordinate(column, result.steps),
                                        grid_coordinate(row, result.steps));
    };
    for (int face = 0; face < cubemap_faces; ++face)
        for (int row = 0; row < side; ++row)
            for (int column = 0; column < side; ++column)
                images_by_symmetry.try_emplace(symmetry_to(grid_direction(face, row, column)));
    for (auto& [symmetry, image] : images_by_symmetry) image = images(symmetry, shapes.face_size);

    tbb::enumerable_thread_specific<CoefficientSum> sums([&] { return CoefficientSum(shapes.face_size); });
    tbb::parallel_for(std::size_t(0), result.lobes.blocks.size(), [&](std::size_t b) {
        if (progress.stop.stop_requested()) return;
        CoefficientSum& sum = sums.local();
        const std::size_t end = std::min(result.lobes.rows, (b + 1) * SparseVectorBlocks::block_rows);
        for (std::size_t i = b * SparseVectorBlocks::block_rows; i < end; ++i) {
            const std::size_t exponent = i / lobes_of_exponent;
            const int column = static_cast<int>(i) % side, row = static_cast<int>(i) / side % side,
                      face = static_cast<int>(i % lobes_of_exponent) / (side * side);
            const auto& image = images_by_symmetry.at(symmetry_to(grid_direction(face, row, column)));
            sum.clear();
            for (const auto& [index, value] :
                 first_lobes[exponent * first_directions.count() + first_directions.of(column, row)])
                sum.add(image[index].index, value * image[index].sign);
            result.lobes.blocks[b].append(sum);
        }
    });
    if (progress.stop.stop_requested()) return interruption();
    return result;
}

Interpolation lobe_interpolation(const LobeVectors& vectors, float exponent, const Vec3f& direction) {
    assert(vectors.first.count(exponent));
    const CubemapPoint point = cubemap_point(Vec3d(direction));
    const double x = grid_index(point.u, vectors.steps), y = grid_index(point.v, vectors.steps);
    const int column = std::clamp(static_cast<int>(x), 0, vectors.steps - 1),
              row = std::clamp(static_cast<int>(y), 0, vectors.steps - 1);
    const auto fx = static_cast<float>(x - column), fy = static_cast<float>(y - row);
    const auto side = static_cast<std::uint32_t>(vectors.steps) + 1;
    const std::uint32_t corner = vectors.first.at(exponent) +
                                 (std::uint32_t(point.face) * side + std::uint32_t(row)) * side +
                                 std::uint32_t(column);
    Interpolation result;
    result.count = 4;
    result.sample = {corner, corner + 1, corner + side, corner + side + 1};
    result.weight = {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy};
    return result;
}

}  // namespace haarfield
