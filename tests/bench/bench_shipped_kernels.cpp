/// Benchmarks of the kernels of `bake` and `relight` on all cores: product integrals, and vectors and frames
/// of just-in-time radiance transfer.

#include <benchmark/benchmark.h>

#include "tests/bench/shipped_kernels.h"

namespace haarfield::bench {
namespace {

void product_integrals(benchmark::State& state, const ShippedKernel& kernel) {
    const double error = kernel.error();
    if (!(error < kernel.tolerance)) return state.SkipWithError("wrong answer, so not timed");
    for (auto _ : state) kernel.run();
    state.SetItemsProcessed(state.iterations() * std::int64_t(kernel.vertices()));  // items: vertices
    state.counters["relative_rmse"] = error;
}

const bool registered = [] {
    for (const ShippedKernel& kernel : shipped_kernels())
        benchmark::RegisterBenchmark(("product_integrals/" + kernel.name).c_str(), product_integrals, kernel)
            ->Unit(benchmark::kMicrosecond)
            ->UseRealTime();
    return true;
}();

}  // namespace
}  // namespace haarfield::bench
