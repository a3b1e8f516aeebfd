#include "shading/bake/ray_scene.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <numeric>

#include "shading/bake/scrambled_sobol.h"
#include "shading/bounces/cosine_directions.h"
#include "shading/scene/scene_light.h"

namespace haarfield {
namespace {

/// Samples of the environment per place with which the share of its light that arrives is estimated.
constexpr std::uint32_t trial_samples = 16;
/// Samples are directed if less than this share of the light arrives.
constexpr double little_light = 0.1;
/// The smallest share of a direction, relative to the largest one: rays at few places may miss a narrow gap.
constexpr float least_share = 1e-3f;

/// Returns the places, and those that a ray from each of them meets.
std::vector<SurfacePlace> with_seen_places(const RayScene& rays, std::span<const SurfacePlace> places) {
    std::vector<SurfacePlace> result(places.begin(), places.end());
    const ScrambledSobol points(0x7365656e);
    for (std::size_t k = 0; k < places.size(); ++k) {
        const auto& [from, normal, instance] = places[k];
        const Vec3f direction =
            cosine_direction(as_place(points(std::uint32_t(k))), normal, axes_across(normal));
        if (const std::optional<SurfacePlace> seen = rays.surfaces.nearest(rays.scene, from, direction))
            result.push_back(*seen);
    }
    return result;
}

bool is_lit(const RayScene& rays, const SurfacePlace& place, const Vec3f& direction) {
    return place.normal.dot(direction) > 0 && !rays.rays.is_blocked(place.from, direction);
}

/// Returns the share of the samples of the environment that reach places.
double arriving_share(const RayScene& rays, std::span<const SurfacePlace> places) {
    std::vector<int> reached(places.size());
    tbb::parallel_for(std::size_t(0), places.size(), [&](std::size_t k) {
        const ScrambledSobol points(mixed_seed(0x74726961, std::uint32_t(k)));
        for (std::uint32_t s = 0; s < trial_samples; ++s)
            reached[k] += is_lit(rays, places[k], rays.environment.sample(points(s)).direction);
    });
    return double(std::accumulate(reached.begin(), reached.end(), 0)) / double(places.size() * trial_samples);
}

ArrivingShares arriving_shares(const RayScene& rays, std::span<const SurfacePlace> places) {
    ArrivingShares shares;
    const std::vector<SunDisc>& suns = rays.scene.environment.suns;
    shares.suns.resize(suns.size());
    const auto share_of = [&](std::size_t seed, const auto& direction) {
        const ScrambledSobol points(mixed_seed(0x63656c6c, std::uint32_t(seed)));
        int reached = 0;
        for (std::size_t k = 0; k < places.size(); ++k)
            reached += is_lit(rays, places[k], direction(points(std::uint32_t(k))));
        return static_cast<float>(double(reached) / double(places.size()));
    };
    tbb::parallel_for(std::size_t(0), shares.cells.size(), [&](std::size_t cell) {
        shares.cells[cell] = share_of(cell, [&](const std::array<double, 2>& at) {
            const double row = double(cell / ArrivingShares::columns) + at[1],
                         column = double(cell % ArrivingShares::columns) + at[0];
            return Vec3f(lat_long_direction(column / ArrivingShares::columns, row / ArrivingShares::rows));
        });
    });
    for (std::size_t i = 0; i < suns.size(); ++i)
        shares.suns[i] = share_of(0, [&](const auto&) { return suns[i].direction; });
    float largest = *std::ranges::max_element(shares.cells);
    for (const float share : shares.suns) largest = std::max(largest, share);
    const auto limit = [&](float& share) {
        share = largest > 0 ? std::max(share, least_share * largest) : 1;
    };
    std::ranges::for_each(shares.cells, limit);
    std::ranges::for_each(shares.suns, limit);
    return shares;
}

}  // namespace

RayScene::RayScene(const ShadedScene& of)
    : scene(of),
      environment(of.environment),
      emitters(scene_emitters(of).triangles),
      lamps(placed_lamps(of.lamps)) {
    rays.build(of);
    for (const ShadedEntity& entity : of.entities)
        surfaces.add_entity(entity.occlusion->original().positions(),
                            entity.occlusion->original().triangles());
    surfaces.place(of);
}

void RayScene::focus(std::span<const SurfacePlace> of_interest) {
    if (of_interest.empty() || environment.is_black()) return;
    const std::vector<SurfacePlace> places = with_seen_places(*this, of_interest);
    if (arriving_share(*this, places) < little_light)
        environment = EnvironmentSampler(scene.environment, arriving_shares(*this, places));
}

}  // namespace haarfield
