#pragma once
/// Automatic exposure from the light alone.

#include "shading/scene/environment.h"

#include <span>
#include <vector>

namespace haarfield {

/// Returns the largest exposure at which a white diffuse sphere (albedo 0.8) does not exceed luminance 1.
/// Diffuse surfaces then do not clip in pictures, and are no darker than necessary. [stops]
///
/// environment  clean (clean_environment), not exposed. Its rotation has no effect.
/// returns      in [-60, 60]; 0 without light.
/// accuracy     0.02 stops: the light of 64 x 32 cells, each from its mean direction, on 1,024 normals.
/// cost         about 20 ms for 1024 x 512 pixels.
float automatic_exposure(const Environment& environment);

/// Light from one direction: that of a local light, whose exposure is fixed, or a part of an environment.
struct ExposedLight {
    Vec3d direction;        ///< Towards the light; unit length.
    double irradiance = 0;  ///< Luminance, on a surface that faces the light. [W/m^2]
};

/// Returns the light of an environment for automatic_exposure: one direction for each of 64 x 32 cells, and
/// one for each sun.
std::vector<ExposedLight> gathered_light(const Environment& environment);

/// Returns the largest exposure of the environment at which the sphere, lit by environment and local lights,
/// does not exceed luminance 1. The environment alone may always reach a sixteenth of this luminance, however
/// bright the local lights are. [stops]
float automatic_exposure(const Environment& environment, std::span<const ExposedLight> local);

/// Returns the exposure for the gathered_light of one environment, or of several that are mixed. [stops]
///
/// cost  1 us per light.
float automatic_exposure(std::span<const ExposedLight> environment, std::span<const ExposedLight> local);

}  // namespace haarfield
