#include <fmt/format.h>

#include <array>

#include "tests/baselines/product_methods.h"
#include "tests/studies/study.h"

namespace haarfield::baseline {

std::vector<PlotPanel> study_depth(std::size_t vertices) {
    constexpr int functions = 6, levels = 6;
    // Figure 4 of the paper: complete frames of 177,000 vertices on a Pentium 4 at 3.2 GHz.
    constexpr std::array<double, levels + 1> published_seconds{0, 0.26, 0.6, 1.3, 2.8, 5.7, 11};
    constexpr double published_vertices = 177000;

    const TexelIntegrals texels = texel_integrals(64, vertices);
    const TreeIntegrals trees = tree_integrals(texels, functions);
    const std::vector<Vec3d> exact = texel_sums(texels, functions), full = texel_sums(trees);
    std::vector<Method> methods;
    for (int depth = 1; depth <= levels; ++depth) {
        methods.push_back(haarfield_method(trees, depth));
        methods.push_back(paper_method(trees, depth));
    }
    const std::vector<double> times = least_microseconds(methods, vertices, DataPlace::memory, 10);

    PlotSeries ours{"haarfield", {}, 1}, papers{"paper's algorithm, this machine", {}, 2},
        published{"paper, 2006: frame / vertices", {}, 7, true};
    PlotSeries to_exact{"against the untruncated texels", {}, 3}, to_full{"against depth 6", {}, 5, true};
    fmt::print(
        "Six functions, {} vertices of the shipped scene, one thread. Paper 2006: frame time / 177,000.\n\n",
        vertices);
    fmt::print("{:>5} {:>14} {:>17} {:>14} {:>14} {:>14}\n", "depth", "haarfield us", "paper's alg. us",
               "paper 2006 us", "RMSE, exact", "RMSE, depth 6");
    for (int depth = 1; depth <= levels; ++depth) {
        const auto first = static_cast<std::size_t>(2 * (depth - 1));
        const std::vector<Rgb> radiance = radiance_by(methods[first], vertices);
        const double exact_error = 100 * relative_rmse(radiance, exact),
                     full_error = 100 * relative_rmse(radiance, full);
        const double then = 1e6 * published_seconds[std::size_t(depth)] / published_vertices;
        ours.points.emplace_back(depth, times[first]);
        papers.points.emplace_back(depth, times[first + 1]);
        published.points.emplace_back(depth, then);
        to_exact.points.emplace_back(depth, exact_error);
        if (depth < levels) to_full.points.emplace_back(depth, full_error);
        fmt::print("{:>5} {:>14.2f} {:>17.2f} {:>14.2f} {:>12.2f} % {:>12.3f} %\n", depth, times[first],
                   times[first + 1], then, exact_error, full_error);
    }
    const PlotAxis depths{"traversal depth", false, {1, 2, 3, 4, 5, 6}};
    return {{"Time", depths, {"µs per vertex, RGB", true, {}}, {ours, papers, published}},
            {"Error", depths, {"relative RMSE, %", true, {}}, {to_exact, to_full}}};
}

}  // namespace haarfield::baseline
