#include "fields/field/ambient_visibility.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace haarfield {
namespace {

/// The wavelets' integrals over solid angle, so that the integral of a tree is one product a node. All
/// faces are alike.
class SolidAngleWavelets {
public:
    explicit SolidAngleWavelets(int face_size) {
        std::vector<double> sums;
        for (int row = 0; row < face_size; ++row)
            for (int column = 0; column < face_size; ++column)
                sums.push_back(texel_solid_angle(column, row, face_size));
        for (int cells = face_size / 2; cells >= 1; cells /= 2) {
            const auto width = static_cast<std::size_t>(cells);
            std::vector<double> means(width * width);
            std::vector<std::array<double, 3>> level(width * width);
            for (std::size_t y = 0; y < width; ++y)
                for (std::size_t x = 0; x < width; ++x)
                    for (std::size_t q = 0; q < 4; ++q) {
                        const double sum = sums[(2 * y + q / 2) * 2 * width + 2 * x + q % 2];
                        means[y * width + x] += sum;
                        for (std::size_t a = 0; a < 3; ++a)
                            level[y * width + x][a] += double(wavelet_sign[a][q]) * sum;
                    }
            sums = std::move(means);
            levels_.push_back(std::move(level));
        }
        std::reverse(levels_.begin(), levels_.end());
        face_ = sums[0];
    }

    /// Integral of a face's tree over the face's solid angle.
    double integral(const Quadtree& tree) const {
        double sum = double(tree.scaling) * face_;
        if (!tree.nodes.empty()) add(tree, 0, 0, 0, 0, sum);
        return sum;
    }

private:
    void add(const Quadtree& tree, std::size_t node_index, std::size_t level, std::size_t x, std::size_t y,
             double& sum) const {
        const Quadtree::Node& node = tree.nodes[node_index];
        const std::array<double, 3>& wavelets = levels_[level][(y << level) + x];
        for (std::size_t a = 0; a < 3; ++a) sum += double(node.wavelet[a]) * wavelets[a];
        for (unsigned q = 0; q < 4; ++q)
            if (const std::int32_t child = child_of(node, q); child != no_node)
                add(tree, static_cast<std::size_t>(child), level + 1, 2 * x + q % 2, 2 * y + q / 2, sum);
    }

    std::vector<std::vector<std::array<double, 3>>> levels_;  ///< Root first; 2^l cells across.
    double face_ = 0;                                         ///< Solid angle of a face. [sr]
};

}  // namespace

std::vector<float> mean_over_directions(const QuadtreePool& pool) {
    const SolidAngleWavelets wavelets(pool.face_size);
    std::vector<double> integrals(pool.faces.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, pool.faces.size(), 256), [&](const auto& range) {
        Quadtree tree;
        for (std::size_t face = range.begin(); face < range.end(); ++face) {
            unpack_face(pool, static_cast<std::uint32_t>(face), tree);
            integrals[face] = wavelets.integral(tree);
        }
    });
    std::vector<float> means(pool.cubemaps.size());
    for (std::size_t handle = 0; handle < means.size(); ++handle) {
        double sum = 0;
        for (const std::uint32_t face : pool.cubemaps[handle]) sum += integrals[face];
        means[handle] = static_cast<float>(sum / (4 * pi));
    }
    return means;
}

AmbientVisibility ambient_visibility(const VisibilityField& field) {
    constexpr float voxels_across = 40;
    const float radius = field.bounds.radius();
    const Vec3f lower = field.bounds.lower - Vec3f(0.5f * radius),
                extent = field.bounds.upper - field.bounds.lower + Vec3f(radius);
    const float longest = std::max({extent.x, extent.y, extent.z});
    AmbientVisibility volume;
    if (!(longest > 0 && std::isfinite(longest))) return volume;
    volume.voxel_size = longest / voxels_across;
    volume.origin = lower;
    for (int k = 0; k < 3; ++k)
        volume.size[static_cast<std::size_t>(k)] =
            1 + static_cast<std::int32_t>(std::min(std::ceil(extent[k] / volume.voxel_size), voxels_across));

    const std::vector<float> means = mean_over_directions(field.pool);
    const auto [width, height, depth] = volume.size;
    volume.values.resize(static_cast<std::size_t>(width * height * depth));
    tbb::parallel_for(0, width, [&, height = height, depth = depth](std::int32_t x) {
        auto value = volume.values.begin() + x * height * depth;
        for (std::int32_t y = 0; y < height; ++y)
            for (std::int32_t z = 0; z < depth; ++z) {
                const Vec3f centre = volume.origin + Vec3f(static_cast<float>(x), static_cast<float>(y),
                                                           static_cast<float>(z)) *
                                                         volume.voxel_size;
                const Interpolation interpolation = field.spherical.interpolation(centre);
                float sum = interpolation.open;
                for (std::size_t i = 0; i < static_cast<std::size_t>(interpolation.count); ++i)
                    sum += interpolation.weight[i] *
                           means[static_cast<std::size_t>(field.spherical_handles[interpolation.sample[i]])];
                *value++ = std::clamp(sum, 0.0f, 1.0f);  // truncated trees overshoot
            }
    });
    return volume;
}

}  // namespace haarfield
