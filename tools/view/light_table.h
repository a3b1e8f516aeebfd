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
    Environment environment;             ///< As in its file, cleaned; neither rotated nor exposed.
    TurnableLight smooth;                ///< The smooth light, for wavelets.
    std::vector<LightSource> sources;    ///< The sources, for shadow rays.
    float automatic_exposure = 0;        ///< Exposure of this light alone. [stops]
    std::vector<ExposedLight> gathered;  ///< gathered_light, for exposures of mixtures and with lamps.
};

/// Reads and encodes lights, and caches the most recent ones.
class LightTable {
public:
    explicit LightTable(const RenderSettings& settings) : settings_(settings) {}

    /// Selects the light or the two lights of a design.
    ///
    /// cost    0.5 s for a new light of 1024 x 512 pixels.
    /// errors  those of the light's files; the previous light then remains selected.
    Result<Done> take(const Design& design);

    /// Reads and encodes a light that may be selected next.
    Result<Done> know(const EnvironmentDescription& light);

    /// @name Light of the selected design
    /// The share, rotation and exposure of the argument may differ from those of the selected design.
    /// @{

    /// Returns the rotated and mixed light in coefficients, not exposed. cost: about 5 ms per light.
    GivenLight momentary(const Design& design, bool few) const;
    const Environment& mixed(const Design& design);  ///< Not rotated; cached until the share changes.
    /// Returns the scene's exposure, or if it is to be found, found_exposure of the rotated mixture. [stops]
    ///
    /// cost  about 3 ms for a mixture, or with lamps.
    float exposure(const Design& design) const;
    /// @}

private:
    Result<std::shared_ptr<const EncodedLight>> encoded(const std::filesystem::path& image,
                                                        const std::optional<AnalyticSky>& sky);

    RenderSettings settings_;
    /// Cached lights by light_key, the most recent last.
    std::vector<std::pair<std::string, std::shared_ptr<const EncodedLight>>> known_;
    std::shared_ptr<const EncodedLight> first_, second_;
    std::optional<std::uint64_t> taken_;  ///< Design::light_stamp.
    std::optional<Environment> mixed_;
    float mixed_share_ = 0;
};

}  // namespace haarfield
