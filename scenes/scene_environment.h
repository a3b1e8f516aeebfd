#pragma once
/// A scene's light, as its description wants it.

#include "fields/base/result.h"
#include "scenes/scene.h"
#include "shading/scene/exposure.h"

namespace haarfield {

struct SceneEntities;

/// The light, and how it came about.
struct SceneEnvironment {
    Environment environment;            ///< Clean, turned and exposed.
    std::string from;                   ///< The image's file, or `sky`.
    float exposure = 0;                 ///< [stops]
    bool is_found = false;              ///< The exposure is found_exposure.
    std::vector<std::string> warnings;  ///< Of what was cleaned, with counts.
};

/// The light without `turn` and exposure: read or made, cleaned, blended and turned about +y.
///
/// warnings  grow by what was cleaned.
/// errors    as read_environment_image.
Result<Environment> described_environment(const Scene& scene, std::vector<std::string>& warnings);

/// The exposure of a scene's light that is to be found: automatic_exposure, with the scene's local lights as
/// they light the camera's target, or the mean place of all instances if the camera is to be found, too.
/// [stops]
///
/// light  turned, not exposed.
float found_exposure(const Scene& scene, const Environment& light);

/// The local lights of a scene at the place that found_exposure exposes.
std::vector<ExposedLight> local_lights(const Scene& scene);

/// The stops that the exposure of a scene's light needs in addition to found_exposure, because its camera
/// stands in a room (room_exposure), or because surfaces emit light there (at most four fewer). 0 if the scene
/// names its exposure.
///
/// light  exposed.
float entity_stops(const Scene& scene, const SceneEntities& entities, const Environment& light);

/// Reads or makes the light, cleans it, finds its exposure if it is to be found, turns it and exposes it.
///
/// errors  as read_environment_image.
Result<SceneEnvironment> scene_environment(const Scene& scene);

}  // namespace haarfield
