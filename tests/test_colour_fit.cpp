#include "shading/bake/colour_fit.h"

#include <gtest/gtest.h>

#include "tests/fixtures/lit_box.h"
#include "tests/fixtures/with_threads.h"

namespace haarfield {
namespace {

/// Radiance in the middles of the floor's triangles.
std::vector<Outgoing> middles(const LitBox& lit, const Mesh& floor) {
    std::vector<InstancePoint> points;
    for (std::uint32_t t = 0; t < floor.triangles.size(); ++t) {
        const auto& [a, b, c] = floor.triangles[t];
        const Vec3f p = (floor.positions[a] + floor.positions[b] + floor.positions[c]) / 3.0f;
        points.push_back(
            {LitBox::floor, *point_on(floor, {&t, 1}, p, Vec3f(0, 1, 0),
                                      lit.example.scene.entities[LitBox::floor].occlusion->sampler())});
    }
    return *point_radiance(lit.shading, points);
}

/// The floor's triangles are of one size.
struct Misfit {
    double square = 0, mean = 0;
};
Misfit misfit(const RadiantMesh& floor, const std::vector<Outgoing>& sampled,
              const std::vector<Outgoing>& middles) {
    Misfit result;
    for (std::size_t t = 0; t < middles.size(); ++t) {
        double mean = 0;
        for (const std::uint32_t v : floor.mesh.triangles[t]) {
            const double off = double(floor.radiance[v].diffuse.x) - double(sampled[v].diffuse.x);
            mean += double(floor.radiance[v].diffuse.x) / 3;
            result.square += off * off / 12;
            result.mean += off / 12;
        }
        const double off = mean - double(middles[t].diffuse.x);
        result.square += 0.75 * off * off;
        result.mean += 0.75 * off;
    }
    return result;
}

TEST(ColourFit, HasTheLeastSquaredErrorAndNoMeanError) {
    const LitBox lit;
    auto meshes = lit.radiant(16);
    RadiantMesh& floor = meshes[LitBox::floor];
    const std::vector<Outgoing> sampled = floor.radiance, exact = middles(lit, floor.mesh);
    const Misfit before = misfit(floor, sampled, exact);
    ASSERT_TRUE(fit_radiance(lit.shading, meshes));
    const Misfit after = misfit(floor, sampled, exact);
    EXPECT_LT(after.square, 0.8 * before.square);
    EXPECT_GT(std::abs(before.mean), 1e-3);
    EXPECT_LT(std::abs(after.mean), 1e-4);
    for (std::size_t v = 0; v < floor.radiance.size(); ++v)
        for (const float step : {-0.02f, 0.02f}) {
            floor.radiance[v].diffuse.x += step;
            EXPECT_GT(misfit(floor, sampled, exact).square, after.square) << v;
            floor.radiance[v].diffuse.x -= step;
        }
}

TEST(ColourFit, ReproducesWhatIsLinearAlongEdgesAndSpreadsWhatIsNot) {
    const Mesh mesh = square_mesh(4, 0, 6);
    std::vector<Outgoing> sampled;
    for (const Vec3f& p : mesh.positions) sampled.push_back({Rgb(5 + p.x, 5 - p.z, 6), Rgb(7 + p.z)});
    std::vector<std::array<Outgoing, 3>> middles(mesh.triangles.size());
    for (std::size_t t = 0; t < middles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k)
            middles[t][k] = (sampled[mesh.triangles[t][k]] + sampled[mesh.triangles[t][(k + 1) % 3]]) * 0.5f;
    const std::vector<Outgoing> linear = fitted_radiance(mesh, sampled, middles);
    for (std::size_t v = 0; v < sampled.size(); ++v) {
        EXPECT_NEAR(linear[v].diffuse.x, sampled[v].diffuse.x, 1e-4f);
        EXPECT_NEAR(linear[v].specular.y, sampled[v].specular.y, 1e-4f);
    }
    // A crease that lies between the vertices: all edges are darker in the middle by 1. The weights of
    // corners and middles are 1/4 and 3/4.
    for (auto& triangle : middles)
        for (Outgoing& middle : triangle) middle.diffuse -= Rgb(1.0f);
    const std::vector<Outgoing> creased = fitted_radiance(mesh, sampled, middles);
    for (std::size_t v = 0; v < sampled.size(); ++v)
        EXPECT_NEAR(creased[v].diffuse.x, sampled[v].diffuse.x - 0.75f, 1e-4f) << v;
}

TEST(ColourFit, IsNonNegativeAndBitIdenticalForAnyNumberOfThreads) {
    const LitBox lit;
    std::vector<std::vector<RadiantMesh>> results;
    for (const std::size_t threads : {1u, 3u}) {
        results.push_back(lit.radiant(10));
        ASSERT_TRUE(with_threads(threads, [&] { return fit_radiance(lit.shading, results.back()); }));
    }
    for (std::size_t i = 0; i < results[0].size(); ++i) {
        EXPECT_EQ(results[0][i].radiance, results[1][i].radiance);
        for (const Outgoing& value : results[0][i].radiance) EXPECT_EQ(value, without_negative(value));
    }
}

}  // namespace
}  // namespace haarfield
