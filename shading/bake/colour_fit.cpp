#include "shading/bake/colour_fit.h"

#include <tbb/parallel_for.h>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>
#include <algorithm>
#include <optional>

#include "shading/visibility/placed_solids.h"

namespace haarfield {
namespace {

/// The weights of a triangle's middle, of the middle of one of its edges, and of a corner.
constexpr double middle_weight = 0.75, edge_weight = 0.25, corner_weight = 1.0 / 12;

/// Returns the middles of the triangles; none where a middle is buried or inside another instance, or where
/// the triangle has no area.
std::vector<std::optional<SurfacePoint>> middles_of(const ShadedScene& scene, const PlacedSolids& solids,
                                                    std::size_t instance, const Mesh& mesh) {
    const LocalSampler& sampler = scene.entities[scene.instances[instance].entity].occlusion->sampler();
    std::vector<std::optional<SurfacePoint>> middles(mesh.triangles.size());
    tbb::parallel_for(std::uint32_t{0}, static_cast<std::uint32_t>(middles.size()), [&](std::uint32_t t) {
        const auto& [a, b, c] = mesh.triangles[t];
        const Vec3f position = (mesh.positions[a] + mesh.positions[b] + mesh.positions[c]) / 3.0f;
        const Vec3f normal = mesh.normals[a] + mesh.normals[b] + mesh.normals[c];
        if (normal.length() > 1e-6f)
            middles[t] = point_on(mesh, {&t, 1}, position, normal.normalized(), sampler);
        if (middles[t] && solids.contain(scene, instance, *middles[t])) middles[t].reset();
    });
    return middles;
}

double area(const Mesh& mesh, const std::array<std::uint32_t, 3>& triangle) {
    const Vec3d a(mesh.positions[triangle[0]]);
    return 0.5 *
           (Vec3d(mesh.positions[triangle[1]]) - a).cross(Vec3d(mesh.positions[triangle[2]]) - a).length();
}

/// The channels of both components.
constexpr int channels = 6;

float& channel(Outgoing& radiance, int c) {
    return (c < 3 ? radiance.diffuse : radiance.specular)[c % 3];
}
float channel(const Outgoing& radiance, int c) {
    return (c < 3 ? radiance.diffuse : radiance.specular)[c % 3];
}

/// The least squares problem of one mesh.
class RadianceFit {
public:
    RadianceFit(const Mesh& mesh, std::span<const Outgoing> sampled)
        : count_(static_cast<Eigen::Index>(sampled.size())),
          wanted_(count_, channels),
          start_(count_, channels) {
        double total_area = 0;
        for (const auto& triangle : mesh.triangles) total_area += area(mesh, triangle);
        // This term preserves the radiance of vertices that no triangle with area has. Its effect on other
        // vertices is below rounding.
        const double kept = 1e-9 * std::max(total_area, 1e-30) / static_cast<double>(count_);
        for (Eigen::Index v = 0; v < count_; ++v) {
            entries_.emplace_back(v, v, kept);
            for (int c = 0; c < channels; ++c) {
                start_(v, c) = channel(sampled[std::size_t(v)], c);
                wanted_(v, c) = kept * start_(v, c);
            }
        }
    }

    /// Adds the squared difference between the sum of the corners times `share` and a sample.
    template <std::size_t corners>
    void add(const std::array<std::uint32_t, corners>& vertices, double share, double weight,
             const Outgoing& sample) {
        for (const Eigen::Index i : vertices) {
            for (const Eigen::Index k : vertices) entries_.emplace_back(i, k, weight * share * share);
            for (int c = 0; c < channels; ++c) wanted_(i, c) += weight * share * double(channel(sample, c));
        }
    }
    /// Adds the squared difference from the sample of a vertex.
    void add(std::uint32_t vertex, double weight) {
        entries_.emplace_back(vertex, vertex, weight);
        wanted_.row(vertex) += weight * start_.row(vertex);
    }

    std::vector<Outgoing> solution() const {
        Eigen::SparseMatrix<double> matrix(count_, count_);
        matrix.setFromTriplets(entries_.begin(), entries_.end());
        Eigen::ConjugateGradient<Eigen::SparseMatrix<double>, Eigen::Lower | Eigen::Upper> solver(matrix);
        solver.setTolerance(1e-6);
        const Eigen::MatrixXd solution = solver.solveWithGuess(wanted_, start_);
        std::vector<Outgoing> radiance;
        for (Eigen::Index v = 0; v < count_; ++v) {
            Outgoing found;
            for (int c = 0; c < channels; ++c) channel(found, c) = static_cast<float>(solution(v, c));
            radiance.push_back(without_negative(found));
        }
        return radiance;
    }

private:
    Eigen::Index count_;
    std::vector<Eigen::Triplet<double>> entries_;
    Eigen::MatrixXd wanted_, start_;
};

/// Returns the fitted radiance of the vertices of a mesh; `middles` by triangle.
std::vector<Outgoing> fitted(const RadiantMesh& shaded, std::span<const std::optional<Outgoing>> middles) {
    const Mesh& mesh = shaded.mesh;
    RadianceFit fit(mesh, shaded.radiance);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        if (!middles[t]) continue;
        const double weight = area(mesh, mesh.triangles[t]);
        fit.add(mesh.triangles[t], 1.0 / 3, weight * middle_weight, *middles[t]);
        for (const std::uint32_t v : mesh.triangles[t]) fit.add(v, weight * corner_weight);
    }
    return fit.solution();
}

}  // namespace

Result<Done> fit_radiance(const PointShading& shading, std::span<RadiantMesh> meshes,
                          const Progress& progress) {
    std::vector<InstancePoint> points;
    std::vector<std::vector<std::optional<SurfacePoint>>> middles;
    const PlacedSolids solids(shading.scene);
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        middles.push_back(middles_of(shading.scene, solids, i, meshes[i].mesh));
        for (const auto& middle : middles.back())
            if (middle) points.push_back({i, *middle});
    }
    HF_TRY(const std::vector<Outgoing> radiance, point_radiance(shading, points, progress));
    std::vector<std::vector<std::optional<Outgoing>>> values;
    auto next = radiance.begin();
    for (const auto& of_mesh : middles) {
        values.emplace_back(of_mesh.size());
        for (std::size_t t = 0; t < of_mesh.size(); ++t)
            if (of_mesh[t]) values.back()[t] = *next++;
    }
    tbb::parallel_for(std::size_t{0}, meshes.size(),
                      [&](std::size_t i) { meshes[i].radiance = fitted(meshes[i], values[i]); });
    return Done{};
}

std::vector<Outgoing> fitted_radiance(const Mesh& mesh, std::span<const Outgoing> sampled,
                                      std::span<const std::array<Outgoing, 3>> middles) {
    RadianceFit fit(mesh, sampled);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const std::array<std::uint32_t, 3>& corners = mesh.triangles[t];
        const double weight = area(mesh, corners);
        for (std::size_t k = 0; k < 3; ++k) {
            fit.add(std::array{corners[k], corners[(k + 1) % 3]}, 0.5, weight * edge_weight, middles[t][k]);
            fit.add(corners[k], weight * corner_weight);
        }
    }
    return fit.solution();
}

}  // namespace haarfield
