#include "shading/bake/path_samples.h"

namespace haarfield {

PathSamples::PathSamples(const EnvironmentSampler& environment, std::uint32_t paths, std::uint32_t seed,
                         std::uint32_t stored)
    : environment_(&environment),
      seed_(seed),
      first_(sorted_points(ScrambledSobol(mixed_seed(seed, 0)), paths)) {
    stored_.reserve(std::size_t(stored) * paths);
    for (std::uint32_t reflection = 0; reflection < stored; ++reflection)
        for (std::uint32_t path = 0; path < paths; ++path) stored_.push_back(made(path, reflection));
}

ReflectionSample PathSamples::made(std::uint32_t path, std::uint32_t reflection) const {
    const std::uint32_t seed = mixed_seed(seed_, reflection + 1);
    const auto points = [&](std::uint32_t choice) { return ScrambledSobol(mixed_seed(seed, choice)); };
    // Without the permutation, the choices of a path at different reflections would be correlated.
    const std::uint32_t index = reflection == 0 ? path : shuffled(path, mixed_seed(seed, 4));
    ReflectionSample sample;
    if (!environment_->is_black()) sample.environment = environment_->sample(points(0)(index));
    sample.emitter = points(1)(index);
    sample.direction = points(2)(index);
    sample.roulette = points(3)(shuffled(index, mixed_seed(seed, 5)))[0];
    return sample;
}

}  // namespace haarfield
