#pragma once
/// Caches the lights of a design, encoded so that they can be rotated, mixed and dimmed in every frame.

#include "shading/scene/exposure.h"
#include "shading/scene/light_sources.h"
#include "shading/scene/turned_light.h"
#include "shading/transfer/session_inputs.h"
#include "tools/view/design.h"

#include <map>

namespace haarfield {

/// A light that can be rotated in every frame.
struct EncodedLight {
    Environment environment;             ///< As its file has it, cleaned; neither turned nor exposed.
    TurnableLight smooth;                ///< What wavelets serve of it,
    std::vector<LightSource> sources;    ///< and what rays do.
    float automatic_exposure = 0;        ///< [stops]
    std::vector<ExposedLight> gathered;  ///< For the exposure of mixtures, and with lamps.
};

/// Reads and encodes lights, and caches the most recent ones.
class LightTable {
public:
    explicit LightTable(const RenderSettings& settings) : settings_(settings) {}

    /// Selects the light or the two lights of a design.
    ///
    /// cost    0.5 s for a new light of 1024 x 512 pixels.
    /// errors  of its files; the previous light then remains selected.
    Result<Done> take(const Design& design);

    /// Reads and encodes a light that may be selected next.
    Result<Done> know(const EnvironmentDescription& light);

    /// @name Of the design that was taken last; share, turn and exposure may be others. @{
    GivenLight momentary(const Design& design, bool few) const;  ///< cost: some 5 ms a light.
    const Environment& mixed(const Design& design);  ///< Not turned; kept until the share changes.
    /// The scene's exposure; if it is to be found, found_exposure of the mixture as it is turned. [stops]
    ///
    /// cost  some 3 ms for a mixture, or with lamps.
    float exposure(const Design& design) const;
    /// @}

private:
    Result<std::shared_ptr<const EncodedLight>> encoded(const std::filesystem::path& image,
                                                        const std::optional<AnalyticSky>& sky);

    RenderSettings settings_;
    /// The most recent last.
    std::vector<std::pair<std::string, std::shared_ptr<const EncodedLight>>> known_;
    std::shared_ptr<const EncodedLight> first_, second_;
    std::optional<std::uint64_t> taken_;  ///< Design::light_stamp.
    std::optional<Environment> mixed_;
    float mixed_share_ = 0;
};

}  // namespace haarfield
