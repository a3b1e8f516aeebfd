#pragma once
/// Random choice among directional lights, in proportion to their irradiance.

#include "shading/scene/light_sources.h"

#include <optional>
#include <span>
#include <vector>

namespace haarfield {

/// The lights of an environment's sources, for Monte Carlo integration.
class SourceChoice {
public:
    SourceChoice() = default;
    /// Computes the lights' probabilities.
    explicit SourceChoice(std::span<const LightSource> sources);

    bool empty() const { return lights_.empty(); }  ///< True if there are no lights.

    /// A light and the probability of its choice.
    struct Chosen {
        const DirectionalLight& light;
        double chance;  ///< In (0, 1].
    };

    /// Returns the light that a uniformly distributed number in [0, 1) selects, by the luminance of its
    /// irradiance.
    ///
    /// returns  nothing if there are no lights, or if the light has no luminance.
    /// cost     logarithmic in the number of lights.
    std::optional<Chosen> choose(double drawn) const;

private:
    std::vector<DirectionalLight> lights_;
    std::vector<double> chances_;  ///< Cumulative; the last is 1.
};

}  // namespace haarfield
