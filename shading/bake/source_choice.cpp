#include "shading/bake/source_choice.h"

#include <algorithm>

namespace haarfield {

SourceChoice::SourceChoice(std::span<const LightSource> sources) : lights_(all_lights(sources)) {
    double sum = 0;
    for (const DirectionalLight& light : lights_)
        chances_.push_back(sum += double(luminance(light.irradiance)));
    for (double& chance : chances_) chance /= sum;
}

std::optional<SourceChoice::Chosen> SourceChoice::choose(double drawn) const {
    if (empty()) return std::nullopt;
    const auto chosen =
        std::min(static_cast<std::size_t>(std::ranges::upper_bound(chances_, drawn) - chances_.begin()),
                 lights_.size() - 1);
    const double chance = chances_[chosen] - (chosen > 0 ? chances_[chosen - 1] : 0);
    if (!(chance > 0)) return std::nullopt;
    return Chosen{lights_[chosen], chance};
}

}  // namespace haarfield
