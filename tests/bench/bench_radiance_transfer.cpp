/// Just-in-time radiance transfer: making the vectors, and frames by them, against full product integrals.

#include <benchmark/benchmark.h>

#include "shading/transfer/light_transfer.h"
#include "shading/transfer/motion_transfer.h"
#include "shading/transfer/view_transfer.h"
#include "tests/fixtures/furnished_room.h"

namespace haarfield::furnished {
namespace {

constexpr float pruning_error = 0.01f;
constexpr double tolerance = 0.02;  ///< Of a frame's relative RMSE: pruning is an expectation, not a bound.
constexpr std::size_t moving = 3;   ///< Instance.

Room& room() {
    static Room made;
    return made;
}

std::int64_t vertex_count(const Room& room) {
    return static_cast<std::int64_t>(TransferRows(room.scene, room.geometry()).count());
}

LightTransfer made_by_light() {
    return *light_transfer(room().scene, room().geometry(), settings(), {pruning_error},
                           dense_coefficients(room().light(), Room::size));
}
ViewTransfer made_by_view() {
    return *view_transfer(room().scene, room().geometry(), settings(), {pruning_error}, room().light(), {});
}
MotionTransfer made_by_motion() {
    return *motion_transfer(room().scene, room().geometry(), settings(), {pruning_error}, room().light(),
                            moving);
}

SceneRadiance frame(const LightTransfer& transfer) {
    SceneRadiance radiance;
    (void)shade_frame(transfer, room().scene, room().geometry(),
                      dense_coefficients(room().light(), Room::size), {}, radiance);
    return radiance;
}
SceneRadiance frame(const ViewTransfer& transfer) {
    SceneRadiance radiance;
    (void)shade_frame(transfer, room().scene, room().geometry(), radiance);
    return radiance;
}
SceneRadiance frame(const MotionTransfer& transfer) {
    SceneRadiance radiance;
    (void)shade_frame(transfer, room().scene, room().geometry(), settings(), {}, FrameQuality::still,
                      radiance);
    return radiance;
}

/// Making the vectors; items: vertices.
template <auto make>
void transfer_vectors(benchmark::State& state) {
    if (!(relative_rmse(frame(make()), room().full()) < tolerance))
        return state.SkipWithError("wrong answer, so not timed");
    for (auto _ : state) benchmark::DoNotOptimize(make());
    state.SetItemsProcessed(state.iterations() * vertex_count(room()));
}
BENCHMARK(transfer_vectors<made_by_light>)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(transfer_vectors<made_by_view>)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(transfer_vectors<made_by_motion>)->Unit(benchmark::kMillisecond)->UseRealTime();

/// A frame; items: vertices.
template <auto make>
void transfer_frame(benchmark::State& state) {
    const auto transfer = make();
    if (!(relative_rmse(frame(transfer), room().full()) < tolerance))
        return state.SkipWithError("wrong answer, so not timed");
    for (auto _ : state) benchmark::DoNotOptimize(frame(transfer));
    state.SetItemsProcessed(state.iterations() * vertex_count(room()));
}
BENCHMARK(transfer_frame<made_by_light>)->Unit(benchmark::kMicrosecond)->UseRealTime();
BENCHMARK(transfer_frame<made_by_view>)->Unit(benchmark::kMicrosecond)->UseRealTime();
BENCHMARK(transfer_frame<made_by_motion>)->Unit(benchmark::kMicrosecond)->UseRealTime();

/// What a frame without vectors costs; items: vertices.
void product_integrals(benchmark::State& state) {
    const SceneLight light = scene_light(room().scene.environment, settings());
    for (auto _ : state)
        benchmark::DoNotOptimize(*scene_radiance({room().scene, room().geometry(), light, settings()}));
    state.SetItemsProcessed(state.iterations() * vertex_count(room()));
}
BENCHMARK(product_integrals)->Unit(benchmark::kMicrosecond)->UseRealTime();

}  // namespace
}  // namespace haarfield::furnished
