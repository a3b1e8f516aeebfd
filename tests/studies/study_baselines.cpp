#include <fmt/format.h>

#include <cmath>

#include "tests/baselines/product_methods.h"
#include "tests/baselines/ray_casting.h"
#include "tests/studies/study.h"

namespace haarfield::baseline {
namespace {

std::size_t node_count(const auto& tree) {
    std::size_t count = 0;
    for (const auto& face : tree.faces) count += face.nodes.size();
    return count;
}

/// Returns the average number of nodes of all factors of a vertex.
double mean_node_count(const TreeIntegrals& trees) {
    std::size_t count = 0;
    for (const auto& factors : trees.vertices)
        for (const CubemapTree& factor : factors) count += node_count(factor);
    return static_cast<double>(count) / static_cast<double>(trees.vertices.size());
}

constexpr int most_rays = 1 << 12;

/// Doubles the number of rays until the error is at most `wanted_error`. Then measures the cost per vertex,
/// the minimum of three passes.
void study_ray_casting(const TexelIntegrals& texels, double wanted_error) {
    const std::size_t vertices = texels.vertices.size();
    RayCaster caster(shipped_scene(), texels);
    const std::vector<Vec3d> exact = texel_sums(texels, 7);
    for (int rays = 16;; rays *= 2) {
        caster.use_rays(rays);
        double error = 0, least = INFINITY;
        for (std::uint32_t pass = 0; pass < 8; ++pass) {
            std::vector<Rgb> radiance;
            const double start = thread_seconds();
            for (std::size_t v = 0; v < vertices; ++v)
                radiance.push_back(
                    caster(texels.vertices[v], static_cast<std::uint32_t>(pass * vertices + v)));
            least = std::min(least, 1e6 * (thread_seconds() - start) / static_cast<double>(vertices));
            const double here = relative_rmse(radiance, exact);
            error += here * here / 8;
        }
        fmt::print("{:<44} {:>9.1f} {:>10.2f} %\n", fmt::format("ray casting, {} rays", rays), least,
                   100 * std::sqrt(error));
        if (std::sqrt(error) <= wanted_error || rays == most_rays) return;
    }
}

/// Measures all methods after verifying them: six functions.
void study_methods(const TexelIntegrals& texels) {
    constexpr int functions = 6;
    const std::size_t vertices = texels.vertices.size();
    const TreeIntegrals trees = tree_integrals(texels, functions);
    const std::vector<Vec3d> exact = texel_sums(texels, functions);
    std::vector<Method> methods;
    for (const NamedMethod& named : all_methods()) methods.push_back(named.make({texels, trees, functions}));
    const auto cache = least_microseconds(methods, vertices, DataPlace::cache, 5);
    const auto memory = least_microseconds(methods, vertices, DataPlace::memory, 10);
    fmt::print("Quadtree nodes: {} of the lighting, {:.0f} of a vertex's other functions together.\n\n",
               node_count(trees.light), mean_node_count(trees));
    fmt::print("{:<44} {:>9} {:>8} {:>9} {:>8} {:>10}\n", "", "from cache", "", "memory", "", "relative");
    fmt::print("{:<44} {:>9} {:>8} {:>9} {:>8} {:>10}\n", "method", "us", "ratio", "us", "ratio", "RMSE");
    for (std::size_t i = 0; i < methods.size(); ++i)
        fmt::print("{:<44} {:>9.2f} {:>8.2f} {:>9.2f} {:>8.2f} {:>8.2f} %\n", methods[i].title, cache[i],
                   cache[i] / cache[0], memory[i], memory[i] / memory[0],
                   100 * relative_rmse(radiance_by(methods[i], vertices), exact));
}

/// Measures the fastest methods for several truncations: six functions.
void study_levels_of_error(const TexelIntegrals& texels) {
    constexpr int functions = 6;
    const std::size_t vertices = texels.vertices.size();
    const std::vector<Vec3d> exact = texel_sums(texels, functions);
    std::vector<Method> methods;
    for (const KeptWavelets kept : {KeptWavelets{60, 20}, KeptWavelets{200, 70}, KeptWavelets{700, 250}}) {
        methods.push_back(haarfield_method(tree_integrals(texels, functions, kept)));
        methods.back().title =
            fmt::format("haarfield, {} wavelets, {} of the light", kept.others, kept.light);
    }
    const TexelIntegrals half = coarser(texels), quarter = coarser(half);
    for (const TexelIntegrals* size : {&quarter, &half, &texels}) {
        for (Method& method :
             std::array{dense_bits_method(*size, functions), dense_bytes_method(*size, functions)}) {
            method.title = fmt::format("{}, {} x {}", method.title, size->face_size, size->face_size);
            methods.push_back(std::move(method));
        }
    }
    const auto cache = least_microseconds(methods, vertices, DataPlace::cache, 5);
    const auto memory = least_microseconds(methods, vertices, DataPlace::memory, 10);
    fmt::print("\n{:<52} {:>10} {:>9} {:>10}\n", "by how much is kept", "cache, us", "memory", "RMSE");
    for (std::size_t i = 0; i < methods.size(); ++i)
        fmt::print("{:<52} {:>10.2f} {:>9.2f} {:>8.2f} %\n", methods[i].title, cache[i], memory[i],
                   100 * relative_rmse(radiance_by(methods[i], vertices), exact));
}

void study_rays(const TexelIntegrals& texels) {
    const TreeIntegrals all_trees = tree_integrals(texels, 7);
    const Method haarfield = haarfield_method(all_trees);
    const double error = relative_rmse(radiance_by(haarfield, texels.vertices.size()), texel_sums(texels, 7));
    fmt::print("\nAll seven functions, so that rays meet the whole scene:\n\n{:<44} {:>9} {:>12}\n", "method",
               "us", "RMSE");
    fmt::print("{:<44} {:>9.1f} {:>10.2f} %\n", haarfield.title,
               least_microseconds(std::span(&haarfield, 1), texels.vertices.size(), DataPlace::memory, 5)[0],
               100 * error);
    study_ray_casting(texels, error);
}

}  // namespace

void study_baselines(std::size_t vertices) {
    fmt::print("Six functions, {} vertices of the shipped scene, 6 x 64 x 64 texels, RGB, one thread.\n",
               vertices);
    for (const StudiedLight light : {StudiedLight::smooth, StudiedLight::whole}) {
        fmt::print("\n{}\n\n",
                   light == StudiedLight::smooth
                       ? "Of the light what remains when the sun is served by rays, as bake has it:"
                       : "All of the light, with the sun in it:");
        const TexelIntegrals texels = texel_integrals(64, vertices, light);
        study_methods(texels);
        study_levels_of_error(texels);
        study_rays(texels);
    }
}

}  // namespace haarfield::baseline
