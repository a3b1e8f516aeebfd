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

/// Light from one direction: of a local light, which has its exposure already, or a part of an environment.
struct ExposedLight {
    Vec3d direction;        ///< Towards the light; unit length.
    double irradiance = 0;  ///< Luminance, on a surface that faces the light. [W/m^2]
};

/// The light of an environment as automatic_exposure uses it: from the mean directions of 64 x 32 cells, and
/// from its suns.
std::vector<ExposedLight> gathered_light(const Environment& environment);

/// The same with local lights: the ball, lit by them and by the exposed environment, shines nowhere brighter
/// than 1. The environment has at least a sixteenth of that to itself, however bright the local lights are.
float automatic_exposure(const Environment& environment, std::span<const ExposedLight> local);

/// The same for light that was gathered before: of one environment, or of several that are mixed.
///
/// cost  1 us a light.
float automatic_exposure(std::span<const ExposedLight> environment, std::span<const ExposedLight> local);

}  // namespace haarfield
