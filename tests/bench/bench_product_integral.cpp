/// Benchmarks of the product integral of six functions at vertices of the shipped scene: haarfield and the
/// baselines.

#include <benchmark/benchmark.h>

#include <cmath>

#include "tests/baselines/product_methods.h"

namespace haarfield::baseline {
namespace {

constexpr int functions = 6;
constexpr std::size_t vertex_count = 256;  // 126 MB as float texels: more than any cache

struct Subject {
    TexelIntegrals texels = texel_integrals(64, vertex_count);
    TreeIntegrals trees = tree_integrals(texels, functions);
    std::vector<Vec3d> exact = texel_sums(texels, functions), truncated = texel_sums(trees);
};

const Subject& subject() {
    static const Subject made;
    return made;
}

/// Caches only the last method. The next run often uses the same one, and all of them together would fill the
/// memory.
const Method& made_method(const NamedMethod* named) {
    static const NamedMethod* last = nullptr;
    static Method method;
    if (named != last) method = named->make({subject().texels, subject().trees, functions});
    last = named;
    return method;
}

void product_integral_of_six_functions(benchmark::State& state, const NamedMethod* named, DataPlace place) {
    const Subject& of = subject();
    const Method& method = made_method(named);
    const std::vector<Rgb> radiance = radiance_by(method, vertex_count);
    if (!(relative_rmse(radiance, method.of_trees ? of.truncated : of.exact) <= method.tolerance))
        return state.SkipWithError("wrong answer, so not timed");
    std::size_t evaluated = 0;
    for (auto _ : state) evaluated += evaluate_all(method, 0, vertex_count, place);
    state.SetItemsProcessed(static_cast<std::int64_t>(evaluated));  // items: vertices, RGB
    state.counters["per_vertex"] = benchmark::Counter(
        static_cast<double>(evaluated), benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
    state.counters["relative_rmse"] = relative_rmse(radiance, of.exact);
}

const bool registered = [] {
    for (const NamedMethod& method : all_methods())
        for (const DataPlace place : {DataPlace::cache, DataPlace::memory})
            benchmark::RegisterBenchmark((std::string("product_integral/") + method.name +
                                          (place == DataPlace::cache ? "/cache" : "/memory"))
                                             .c_str(),
                                         product_integral_of_six_functions, &method, place)
                ->Unit(benchmark::kMillisecond);
    return true;
}();

}  // namespace
}  // namespace haarfield::baseline
