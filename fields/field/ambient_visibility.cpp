#include "fields/field/ambient_visibility.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace haarfield {
namespace {

/// Integrals over the solid angle of a face: of a function, and of the function times the direction's
/// components along the face's axis, u and v. [sr]
using FaceIntegrals = std::array<double, 4>;

/// The integrals of all wavelets of a face, so that those of a tree cost a few products per node. The same
/// for all faces.
class SolidAngleWavelets {
public:
    explicit SolidAngleWavelets(int face_size) {
        std::vector<FaceIntegrals> sums;
        for (int row = 0; row < face_size; ++row)
            for (int column = 0; column < face_size; ++column) {
                const double u = (2 * column + 1.0) / face_size - 1, v = (2 * row + 1.0) / face_size - 1,
                             angle = texel_solid_angle(column, row, face_size),
                             along_axis = angle / std::sqrt(1 + u * u + v * v);
                sums.push_back({angle, along_axis, u * along_axis, v * along_axis});
            }
        for (int cells = face_size / 2; cells >= 1; cells /= 2) {
            const auto width = static_cast<std::size_t>(cells);
            std::vector<FaceIntegrals> means(width * width);
            std::vector<std::array<FaceIntegrals, 3>> level(width * width);
            for (std::size_t y = 0; y < width; ++y)
                for (std::size_t x = 0; x < width; ++x)
                    for (std::size_t q = 0; q < 4; ++q) {
                        const FaceIntegrals& sum = sums[(2 * y + q / 2) * 2 * width + 2 * x + q % 2];
                        add(means[y * width + x], 1, sum);
                        for (std::size_t a = 0; a < 3; ++a)
                            add(level[y * width + x][a], double(wavelet_sign[a][q]), sum);
                    }
            sums = std::move(means);
            levels_.push_back(std::move(level));
        }
        std::reverse(levels_.begin(), levels_.end());
        face_ = sums[0];
    }

    /// Returns the integrals of a face's tree.
    FaceIntegrals integrals(const Quadtree& tree) const {
        FaceIntegrals sum{};
        add(sum, double(tree.scaling), face_);
        if (!tree.nodes.empty()) add_nodes(tree, 0, 0, 0, 0, sum);
        return sum;
    }

private:
    static void add(FaceIntegrals& sum, double factor, const FaceIntegrals& added) {
        for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += factor * added[k];
    }

    void add_nodes(const Quadtree& tree, std::size_t node_index, std::size_t level, std::size_t x,
                   std::size_t y, FaceIntegrals& sum) const {
        const Quadtree::Node& node = tree.nodes[node_index];
        const std::array<FaceIntegrals, 3>& wavelets = levels_[level][(y << level) + x];
        for (std::size_t a = 0; a < 3; ++a)
            if (node.wavelet[a] != 0) add(sum, double(node.wavelet[a]), wavelets[a]);
        for (unsigned q = 0; q < 4; ++q)
            if (const std::int32_t child = child_of(node, q); child != no_node)
                add_nodes(tree, static_cast<std::size_t>(child), level + 1, 2 * x + q % 2, 2 * y + q / 2,
                          sum);
    }

    /// Root first; 2^l cells across at level l.
    std::vector<std::vector<std::array<FaceIntegrals, 3>>> levels_;
    FaceIntegrals face_{};
};

/// Limits the length to 1, the largest mean of unit vectors.
Vec3f shortened(const Vec3f& mean) {
    return mean / std::max(1.0f, mean.length());
}

}  // namespace

std::vector<DirectionMeans> mean_over_directions(const QuadtreePool& pool) {
    const SolidAngleWavelets wavelets(pool.face_size);
    std::vector<FaceIntegrals> integrals(pool.faces.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, pool.faces.size(), 256), [&](const auto& range) {
        Quadtree tree;
        for (std::size_t face = range.begin(); face < range.end(); ++face) {
            unpack_face(pool, static_cast<std::uint32_t>(face), tree);
            integrals[face] = wavelets.integrals(tree);
        }
    });
    std::vector<DirectionMeans> means(pool.cubemaps.size());
    for (std::size_t handle = 0; handle < means.size(); ++handle) {
        double sum = 0;
        Vec3d directions(0.0);
        for (int face = 0; face < cubemap_faces; ++face) {
            const auto& [all, along_axis, along_u, along_v] =
                integrals[pool.cubemaps[handle][static_cast<std::size_t>(face)]];
            const auto axis = cubemap_direction<Vec3d>(face, 0, 0);
            sum += all;
            directions += axis * along_axis + (cubemap_direction<Vec3d>(face, 1, 0) - axis) * along_u +
                          (cubemap_direction<Vec3d>(face, 0, 1) - axis) * along_v;
        }
        means[handle] = {static_cast<float>(sum / (4 * pi)), Vec3f(directions / (4 * pi))};
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

    const std::vector<DirectionMeans> means = mean_over_directions(field.pool);
    const auto [width, height, depth] = volume.size;
    volume.values.resize(static_cast<std::size_t>(width * height * depth));
    volume.directions.assign(volume.values.size(), Vec3f(0.0f));
    tbb::parallel_for(0, width, [&, height = height, depth = depth](std::int32_t x) {
        auto voxel = static_cast<std::size_t>(x * height * depth);
        for (std::int32_t y = 0; y < height; ++y)
            for (std::int32_t z = 0; z < depth; ++z, ++voxel) {
                const Vec3f centre = volume.origin + Vec3f(static_cast<float>(x), static_cast<float>(y),
                                                           static_cast<float>(z)) *
                                                         volume.voxel_size;
                const Interpolation interpolation = field.spherical.interpolation(centre);
                float open = interpolation.open;
                Vec3f directions(0.0f);  // open directions cancel
                for (std::size_t i = 0; i < static_cast<std::size_t>(interpolation.count); ++i) {
                    const DirectionMeans& mean =
                        means[static_cast<std::size_t>(field.spherical_handles[interpolation.sample[i]])];
                    open += interpolation.weight[i] * mean.visibility;
                    directions += mean.direction * interpolation.weight[i];
                }
                volume.values[voxel] = std::clamp(open, 0.0f, 1.0f);  // truncated trees may overshoot
                // If the mean visibility is nearly zero, only the truncation error remains.
                constexpr float least_open = 1e-3f;
                if (open > least_open) volume.directions[voxel] = shortened(directions / open);
            }
    });
    return volume;
}

}  // namespace haarfield
