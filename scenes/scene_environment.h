#pragma once
/// The environment that a scene describes.

#include "fields/base/result.h"
#include "scenes/scene.h"
#include "shading/scene/exposure.h"

namespace haarfield {

struct SceneEntities;

/// The environment, and how it was obtained.
struct SceneEnvironment {
    Environment environment;            ///< Cleaned, rotated and exposed.
    std::string from;                   ///< The image's file, `sky`, or `none`.
    float exposure = 0;                 ///< [stops]
    bool is_found = false;              ///< The exposure comes from found_exposure.
    std::vector<std::string> warnings;  ///< Counts of values that were cleaned.
};

/// Reads or computes the environment, cleans it, blends it and rotates it about +y. Applies neither `turn`
/// nor exposure.
///
/// warnings  receives counts of cleaned values.
/// errors    as read_environment_image.
Result<Environment> described_environment(const Scene& scene, std::vector<std::string>& warnings);

/// Computes the exposure of a scene whose file leaves it open: automatic_exposure of the environment and of
/// the local lights as they light one place. That place is the camera's target, or the mean position of all
/// instances if the camera is to be found. [stops]
///
/// light  rotated, not exposed.
float found_exposure(const Scene& scene, const Environment& light);

/// Returns the local lights of a scene at the place for which found_exposure exposes.
std::vector<ExposedLight> local_lights(const Scene& scene);

/// Returns the stops to add to found_exposure: those of room_exposure if the camera is in a room, and at most
/// four fewer if surfaces emit light there. 0 if the scene sets its exposure. [stops]
///
/// light  exposed.
float entity_stops(const Scene& scene, const SceneEntities& entities, const Environment& light);

/// Reads or computes the environment, cleans it, rotates it and exposes it. Finds the exposure if the scene
/// does not set it.
///
/// errors  as read_environment_image.
Result<SceneEnvironment> scene_environment(const Scene& scene);

}  // namespace haarfield
